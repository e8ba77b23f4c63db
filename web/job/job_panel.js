// What is known of a job, beside its picture: how it stands, its plan and what it left out, what it
// cost, what happened to it.
import { jobUrl } from "../api.js";
import { definitions, make, setText } from "../elements.js";
import { documentRows, planRows, rayCounts, skippedRows, stageTimes, statisticsRows } from "./facts.js";
import { Marks } from "./marks.js";
import { BarPlot } from "./plots.js";
import { Poll } from "../poll.js";
import { ENDED, percent, timeLeft } from "./progress_text.js";

const stage = (s) => s >= 100 ? `${s.toFixed(0)} s` : s >= 0.1 ? `${s.toFixed(2)} s` : `${(s * 1000).toFixed(1)} ms`;
const count = (n) => n >= 1e6 ? `${(n / 1e6).toFixed(2)} million` : String(n);

export class JobPanel {
  constructor(at, onConnection, onJob) {
    this.at = at;
    this.marks = new Marks(at.mark, (job) => { this.show(job); onJob(job); });
    this.times = new BarPlot(at.times, { title: "CPU time by stage", columns: ["Stage", "CPU time"], show: stage });
    this.rays = new BarPlot(at.rays, { title: "Rays by kind", columns: ["Kind", "Rays"], show: count });
    this.poll = new Poll((job) => this.show(job), onConnection, { quickMs: 1000, slowMs: 2000 });
  }

  // null: no job. Looked at until the job has ended.
  open(id) {
    this.id = id;
    this.at.section.hidden = true;
    this.at.log.replaceChildren();
    this.poll.follow(id ? jobUrl(id) : null).catch(() => {});
  }

  show(job) {
    if (job.id !== this.id) return;
    if (ENDED.has(job.state)) this.poll.follow(null);
    const { at } = this;
    at.section.hidden = false;
    this.marks.show(job);
    at.again.href = `submit.html?job=${job.id}`;
    replaceRows(at.standing, [
      ["Id", job.id],
      ["Labels", (job.labels ?? []).join(", ")],
      ["Comment", job.document?.comment],
      ["State", job.state],
      ["Done", `${percent(job.state, job.progress?.fraction)} %`],
      ["Time left", timeLeft(job)],
      ["Submitted", new Date(job.created).toLocaleString()],
      ["Priority", String(job.priority)],
      ...documentRows(job.document),
    ]);
    replaceRows(at.plan, planRows(job.plan));
    const skipped = skippedRows(job.plan);
    setText(at.skippedTitle, `Skipped: ${skipped.length}, and why`);
    at.skippedPart.hidden = skipped.length === 0;
    replaceRows(at.skipped, skipped);
    replaceRows(at.statistics, statisticsRows(job.statistics));
    this.times.draw(stageTimes(job.statistics));
    this.rays.draw(rayCounts(job.statistics));
    this.showLog(job.log ?? []);
  }

  // Lines are kept: only the last may change and new ones follow, but for a gap in the middle.
  showLog(log) {
    const { children } = this.at.log;
    log.forEach((line, i) => {
      if (!children[i]) this.at.log.append(make("li", {}, make("time"), make("span")));
      const [time, text] = children[i].children;
      children[i].dataset.what = line.what;
      time.dateTime = line.time;
      setText(time, clock(line.time));
      setText(text, line.times > 1 ? `${line.text} (${line.times} times, until ${clock(line.until)})` : line.text);
    });
    while (children.length > log.length) this.at.log.lastElementChild.remove();
  }
}

const clock = (time) => new Date(time).toLocaleTimeString();

function replaceRows(list, rows) {
  const known = rows.filter(([, value]) => value);
  const key = JSON.stringify(known);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...definitions(known));
}

// Jobs as rows. A row stays the same element while its job is on the page, so that nothing flickers
// and keyboard focus stays where it is.
import { make, setText } from "../elements.js";
import { ENDED, percent, timeLeft } from "./progress_text.js";

export class JobRows {
  constructor(list) {
    this.list = list;
    this.rows = new Map();
  }

  show(jobs) {
    const seen = new Set(jobs.map((job) => job.id));
    for (const [id, row] of this.rows)
      if (!seen.has(id)) { row.element.remove(); this.rows.delete(id); }
    let at = this.list.firstElementChild;
    for (const job of jobs) {
      let row = this.rows.get(job.id);
      if (!row) this.rows.set(job.id, row = makeRow(job.id));
      fill(row, job);
      if (row.element === at) at = at.nextElementSibling;
      else this.list.insertBefore(row.element, at);
    }
  }
}

function makeRow(id) {
  const parts = {
    state: make("span", { class: "state" }),
    when: make("time"),
    size: make("span", { class: "size" }),
    priority: make("span", { class: "size" }),
    bar: make("progress", { max: 100, value: 0, "aria-label": `Progress of job ${id.slice(-8)}` }),
    done: make("span", { class: "done" }),
  };
  const element = make("li", { class: "row job" },
    make("a", { href: `./#/jobs/${id}`, title: id }, `Job ${id.slice(-8)}`),
    parts.state, make("span", { class: "part" }, parts.bar, parts.done), parts.when, parts.size, parts.priority,
    make("a", { href: `submit.html?job=${id}`, "aria-label": `Edit job ${id.slice(-8)} and submit it again` }, "Edit"));
  return { element, ...parts };
}

function fill(row, job) {
  const value = percent(job.state, job.progress?.fraction);
  setText(row.state, job.state);
  row.state.dataset.state = job.state;
  setText(row.when, new Date(job.created).toLocaleString());
  row.when.dateTime = job.created;
  setText(row.size, job.width ? `${job.width} × ${job.height}` : "");
  setText(row.priority, job.priority ? `priority ${String(job.priority).replace("-", "−")}` : "");
  row.bar.value = value;
  row.bar.hidden = ENDED.has(job.state) && job.state !== "finished";
  const left = timeLeft(job);
  setText(row.done, row.bar.hidden ? "" : left ? `${value} %, ${left}` : `${value} %`);
}

// Jobs as rows. A row stays the same element while its job is on the page, so that nothing flickers
// and keyboard focus stays where it is.
import { make, setText } from "../elements.js";
import { ENDED, nameOf, percent, timeLeft } from "./progress_text.js";
import { showThumbnail } from "./thumbnail.js";

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
    name: make("a", { href: `./#/jobs/${id}`, title: id }),
    picture: make("img", { hidden: true }),
    labels: make("span", { class: "labels" }),
    edit: make("a", { href: `submit.html?job=${id}` }, "Edit"),
    state: make("span", { class: "state" }),
    when: make("time"),
    size: make("span", { class: "size" }),
    priority: make("span", { class: "size" }),
    bar: make("progress", { max: 100, value: 0 }),
    done: make("span", { class: "done" }),
  };
  const element = make("li", { class: "row job" },
    parts.name, make("span", { class: "thumb" }, parts.picture), parts.state, make("span", { class: "part" }, parts.bar, parts.done), parts.when, parts.size, parts.priority,
    parts.edit, parts.labels);
  return { element, ...parts };
}

// A label leads to all jobs that have it.
function fillLabels(list, labels) {
  const key = JSON.stringify(labels ?? []);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...(labels ?? []).map((label) =>
    make("a", { class: "label", href: `jobs.html?${new URLSearchParams({ label })}`, "aria-label": `Jobs with the label ${label}` }, label)));
}

function fill(row, job) {
  const value = percent(job.state, job.progress?.fraction);
  const name = nameOf(job);
  setText(row.name, name);
  row.bar.setAttribute("aria-label", `Progress of ${name}`);
  row.edit.setAttribute("aria-label", `Edit ${name} and submit it again`);
  showThumbnail(row.picture, job);
  fillLabels(row.labels, job.labels);
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

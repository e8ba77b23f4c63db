// The list of jobs: newest first, refreshed while the page is seen, older pages on demand.
import { listJobs } from "../api.js";
import { nameOf } from "./progress_text.js";
import { showThumbnail } from "./thumbnail.js";

const REFRESH_MS = 2000;

export class JobList {
  constructor({ list, empty, more }, onConnection) {
    this.list = list;
    this.empty = empty;
    this.more = more;
    this.onConnection = onConnection;
    this.rows = new Map();
    this.older = [];
    more.addEventListener("click", () => this.loadOlder());
    document.addEventListener("visibilitychange", () => { if (!document.hidden) this.refresh(); });
    this.refresh();
  }

  async refresh() {
    clearTimeout(this.timer);
    try {
      const page = await listJobs();
      if (this.older.length === 0) this.next = page.next;
      this.show([...page.jobs, ...this.older]);
      this.onConnection("live");
    } catch (error) {
      this.onConnection("lost", error);
    }
    if (!document.hidden) this.timer = setTimeout(() => this.refresh(), REFRESH_MS);
  }

  async loadOlder() {
    try {
      const page = await listJobs(this.next);
      this.older.push(...page.jobs);
      this.next = page.next;
      await this.refresh();
    } catch (error) {
      this.onConnection("lost", error);
    }
  }

  select(id) { this.selected = id; for (const [key, row] of this.rows) mark(row, key === id); }

  // Rows are kept and moved, not made anew, so that keyboard focus stays where it is.
  show(jobs) {
    const seen = new Set();
    let at = this.list.firstElementChild;
    for (const job of jobs) {
      if (seen.has(job.id)) continue;
      seen.add(job.id);
      let row = this.rows.get(job.id);
      if (!row) this.rows.set(job.id, row = makeRow(job.id));
      fill(row, job);
      mark(row, job.id === this.selected);
      if (row === at) at = at.nextElementSibling;
      else this.list.insertBefore(row, at);
    }
    for (const [id, row] of this.rows)
      if (!seen.has(id)) { row.remove(); this.rows.delete(id); }
    this.empty.hidden = seen.size > 0;
    this.more.hidden = !this.next;
  }
}

function makeRow(id) {
  const row = document.createElement("li");
  const link = document.createElement("a");
  link.href = `#/jobs/${id}`;
  for (const name of ["name", "when", "state", "size", "part"]) {
    const span = document.createElement("span");
    span.className = name;
    link.append(span);
  }
  const thumb = document.createElement("span");
  thumb.className = "thumb";
  thumb.append(document.createElement("img"));
  link.append(thumb);
  row.append(link);
  return row;
}

function setText(element, text) { if (element.textContent !== text) element.textContent = text; }

function fill(row, job) {
  const [name, when, state, size, part, thumb] = row.firstElementChild.children;
  setText(name, job.name ?? "");
  name.hidden = !job.name;
  showThumbnail(thumb.firstElementChild, job, job.name ? "" : nameOf(job));
  setText(when, new Date(job.created).toLocaleString());
  setText(state, job.paused ? `${job.state}, paused` : job.state);
  state.dataset.state = job.state;
  setText(size, job.width ? `${job.width} × ${job.height}` : job.id.slice(-8));
  const fraction = job.progress?.fraction ?? 0;
  setText(part, job.state === "running" ? `${Math.min(99, Math.floor(fraction * 100))} %` : "");
}

function mark(row, selected) {
  const link = row.firstElementChild;
  if (selected) link.setAttribute("aria-current", "page");
  else link.removeAttribute("aria-current");
}

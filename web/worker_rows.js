// Workers as cards; each stays the same element while its worker is there.
import { make, setText } from "./elements.js";

const size = (bytes) => bytes >= 1e9 ? `${(bytes / 1e9).toFixed(2)} GB` : `${(bytes / 1e6).toFixed(1)} MB`;
const rate = (worker) => `${worker.tiles_per_s.toFixed(1)} tiles/s, ${(worker.rays_per_s / 1e6).toFixed(2)} Mrays/s`;
const rays = (n) => n >= 1e9 ? `${(n / 1e9).toFixed(2)} billion rays` : `${(n / 1e6).toFixed(1)} million rays`;
const FACTS = [
  ["Rate", rate],
  ["Done", (worker) => `${worker.tiles_done} tiles, ${rays(worker.rays)}`],
  ["Threads", (worker) => String(worker.threads)],
  ["Instructions", (worker) => worker.isa],
  ["Embree", (worker) => worker.embree],
  ["Build", (worker) => worker.build],
  ["Phase", (worker) => worker.phase],
  ["Memory", (worker) => `${size(worker.rss_bytes)}, ${size(worker.peak_rss_bytes)} at most`],
  ["CPU time", (worker) => `${(worker.cpu_us / 1e6).toFixed(1)} s`],
  ["Where", (worker) => worker.local ? `this machine, process ${worker.pid}` : `another link, process ${worker.pid}`],
];

export class WorkerRows {
  // onDrain(worker, drain)
  constructor(list, onDrain) {
    Object.assign(this, { list, onDrain, rows: new Map() });
  }

  show(workers) {
    const seen = new Set(workers.map((worker) => worker.id));
    for (const [id, row] of this.rows)
      if (!seen.has(id)) { row.element.remove(); this.rows.delete(id); }
    for (const worker of workers) {
      let row = this.rows.get(worker.id);
      if (!row) {
        this.rows.set(worker.id, row = this.makeRow(worker));
        this.list.append(row.element);
      }
      fill(row, worker);
    }
  }

  makeRow(worker) {
    const facts = FACTS.map(([name]) => [make("dt", {}, name), make("dd")]);
    const row = {
      state: make("span", { class: "state" }),
      work: make("dd", { class: "work" }),
      button: make("button", { type: "button" }),
      reason: make("p", { class: "reason" }),
      facts: facts.map(([, value]) => value),
    };
    row.button.addEventListener("click", () => this.onDrain(row.worker, !isSetAside(row.worker)));
    row.element = make("li", { class: "row worker", "data-worker": worker.id },
      make("div", { class: "bar" }, make("h2", {}, worker.name), row.state, row.button), row.reason,
      make("dl", {}, make("dt", {}, "Works on"), row.work, ...facts.flat()));
    return row;
  }
}

const isSetAside = ({ state }) => state === "draining" || state === "quarantined";

function fill(row, worker) {
  row.worker = worker;
  setText(row.state, worker.state);
  row.state.dataset.state = worker.state;
  const { quarantine } = worker, action = isSetAside(worker) ? "Take back" : "Drain";
  setText(row.reason, quarantine ? `It ${quarantine.reason}. It gets no tiles for ${Math.ceil(quarantine.seconds_left / 60)} more min, unless it is taken back.` : "");
  row.reason.hidden = !quarantine;
  setText(row.button, action);
  row.button.setAttribute("aria-label", `${action} ${worker.name}`);
  FACTS.forEach(([, text], i) => setText(row.facts[i], text(worker)));
  fillWork(row.work, worker.work ?? []);
}

// Links are kept while they say the same, or the one with the focus would go every second.
function fillWork(cell, work) {
  const key = work.map(({ job, frame }) => `${job} ${frame}`).join();
  if (cell.dataset.key !== key) {
    cell.dataset.key = key;
    cell.replaceChildren(...work.map(({ job, frame }) => make("span", {},
      make("a", { href: `./#/jobs/${job}`, title: job }, `job ${job.slice(-8)}, frame ${frame}`), make("span"))));
    if (work.length === 0) cell.textContent = "nothing";
  }
  work.forEach(({ tiles }, i) => setText(cell.children[i].lastElementChild, ` (${tiles === 1 ? "1 tile" : `${tiles} tiles`}) `));
}

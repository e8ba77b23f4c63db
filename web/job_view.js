// One job: its events, its picture, what can be done with it.
import { cancelJob, eventsUrl, getJob, imageUrl, pixelsUrl } from "./api.js";
import { facts } from "./facts.js";
import { Picture } from "./picture.js";
import { followPixels } from "./pixel_feed.js";

const ENDED = new Set(["finished", "failed", "cancelled"]);
const SHOWN_LAYERS = ["beauty", "direct", "indirect", "emission", "albedo", "normal", "depth",
                      "visibility", "slope_min", "slope_max", "filter_width", "diffuse_direct",
                      "diffuse_indirect", "occlusion", "error", "samples"];

const seconds = (s) => s < 90 ? `${Math.ceil(s)} s` : s < 5400 ? `${Math.ceil(s / 60)} min` : `${(s / 3600).toFixed(1)} h`;

export class JobView {
  constructor(elements, onConnection) {
    this.at = elements;
    this.onConnection = onConnection;
    try {
      this.picture = new Picture(elements.canvas);
      this.picture.onRestored = () => this.follow();
    } catch (error) {
      this.note(error.message);
    }
    elements.cancel.addEventListener("click", () => this.cancel());
    elements.exposure.addEventListener("input", () => this.setExposure(Number(elements.exposure.value)));
    elements.exposureReset.addEventListener("click", () => this.setExposure(0));
    elements.layer.addEventListener("change", () => { this.layer = elements.layer.value; this.follow(); });
  }

  // Shows a job; the one before is left.
  async open(id) {
    this.close();
    this.id = id;
    this.layer = "beauty";
    this.announced = -1;
    this.ended = this.wasLive = false;
    this.at.section.hidden = false;
    this.at.title.textContent = `Job ${id}`;
    this.at.announce.textContent = "";
    this.showProblem(null);
    this.showProgress({ fraction: 0 });
    if (this.picture) this.picture.clear();
    this.listen();
    this.follow();
    await this.reload();
  }

  close() {
    this.stopPixels?.();
    this.events?.close();
    this.id = null;
    this.at.section.hidden = true;
  }

  async reload() {
    const { id } = this;
    try {
      const job = await getJob(id);
      if (this.id === id) this.show(job);
    } catch (error) {
      if (this.id === id) this.showProblem(error.status === 404 ? "There is no such job." : error.message);
    }
  }

  listen() {
    const events = this.events = new EventSource(eventsUrl(this.id));
    const on = (name, act) => events.addEventListener(name, (event) => { if (event.data) act(JSON.parse(event.data)); });
    events.onopen = () => this.onConnection("live");
    events.onerror = () => {
      // A stream that ended with its job is closed by us; anything else reconnects by itself.
      if (this.ended) events.close();
      else this.onConnection("connecting");
    };
    on("snapshot", (job) => this.show(job));
    on("progress", (progress) => this.showProgress(progress));
    on("state", (change) => { this.state = change.state; this.reload(); });
    on("frame", () => this.reload());
  }

  follow() {
    this.stopPixels?.();
    if (!this.picture || !this.id) return;
    this.picture.setNormals(this.layer === "normal");
    this.picture.clear();
    this.at.canvasNote.hidden = true;
    this.fetchPixels();
  }

  fetchPixels() {
    this.stopPixels?.();
    if (!this.picture) return;
    this.stopPixels = followPixels(pixelsUrl(this.id, this.layer), (block) => {
      try { this.picture.put(block); } catch (error) { this.note(error.message); }
    }, (state, error) => {
      if (state === "lost" && error && !this.ended) this.onConnection("connecting", error);
    });
  }

  // Everything that GET /v1/jobs/{id} says.
  show(job) {
    this.state = job.state;
    this.frame = job.document?.frames?.first ?? 1;
    this.showProgress(job.progress ?? {});
    this.showLayers(job.document?.layers ?? ["beauty"]);
    this.showProblem(job.error ? `${job.error.pointer ? `${job.error.pointer}: ` : ""}${job.error.detail ?? job.error.title}` : null);
    this.at.cancel.disabled = ENDED.has(job.state);
    this.showDownloads(job);
    this.at.warnings.replaceChildren(...(job.warnings ?? []).map((text) => textElement("li", text)));
    this.at.facts.replaceChildren(...facts(job).flatMap(([name, value]) => [textElement("dt", name), textElement("dd", value)]));
    if (!ENDED.has(job.state)) this.wasLive = true;
    else if (!this.ended) this.end(job);
  }

  end(job) {
    this.ended = true;
    this.events?.close();
    this.at.announce.textContent = `Job ${job.state}`;
    // A live feed may end with blocks unsent. That of a finished job gives the whole picture once:
    // ask for it, over the picture that is there.
    if (job.state === "finished" && this.wasLive) this.fetchPixels();
  }

  showProgress({ fraction = 0, eta_s: eta, tiles_done: done, tiles_total: total }) {
    const finished = this.state === "finished";
    const percent = finished ? 100 : Math.min(99, Math.floor(fraction * 100));
    this.at.progress.value = percent;
    let text = `${percent} %`;
    if (this.state && !finished) text += ` · ${this.state}`;
    if (total && !ENDED.has(this.state)) text += ` · ${done} of ${total} tiles`;
    if (Number.isFinite(eta) && !ENDED.has(this.state)) text += ` · ${seconds(eta)} left`;
    if (finished) text += " · finished";
    this.at.progressText.textContent = text;
    if (Math.floor(percent / 10) > this.announced) {
      this.announced = Math.floor(percent / 10);
      this.at.announce.textContent = `${percent} percent`;
    }
  }

  showLayers(layers) {
    const known = SHOWN_LAYERS.filter((name) => layers.includes(name));
    const now = [...this.at.layer.options].map((option) => option.value);
    if (known.join() !== now.join())
      this.at.layer.replaceChildren(...known.map((name) => new Option(name, name, false, name === this.layer)));
  }

  showDownloads(job) {
    for (const kind of ["exr", "png"]) {
      const link = this.at[`download_${kind}`];
      link.hidden = job.state !== "finished";
      link.href = imageUrl(this.id, this.frame, kind);
      link.download = `${this.id}.${kind}`;
    }
  }

  setExposure(ev) {
    this.at.exposure.value = String(ev);
    this.at.exposureText.textContent = `${ev > 0 ? "+" : ""}${ev} EV`;
    this.picture?.setExposure(ev);
  }

  async cancel() {
    try { await cancelJob(this.id); } catch (error) { this.showProblem(error.message); }
    await this.reload();
  }

  showProblem(text) {
    this.at.problem.hidden = !text;
    this.at.problem.textContent = text ?? "";
  }

  note(text) {
    this.at.canvasNote.hidden = false;
    this.at.canvasNote.textContent = text;
  }
}

function textElement(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}

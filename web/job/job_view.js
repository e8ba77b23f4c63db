// One job: its events, its picture, what can be done with it.
import { eventsUrl, getJob, imageUrl } from "../api.js";
import { ENDED, firstFrame, percent as percentOf, timeLeft } from "./progress_text.js";
import { Player } from "../sequence/player.js";
import { Steering } from "./steering.js";

const SOON_MS = 100;

export class JobView {
  constructor(picture, elements, onConnection) {
    this.picture = picture;
    this.at = elements;
    this.onConnection = onConnection;
    this.steering = new Steering(picture, elements.steering, (job) => this.show(job));
    this.player = new Player(picture, elements.player, () => this.showDownloads());
  }

  // Shows a job; the one before is left.
  async open(id) {
    this.close();
    this.id = id;
    this.announced = -1;
    this.state = this.revision = undefined;
    this.ended = this.paused = false;
    this.at.section.hidden = false;
    this.at.title.textContent = `Job ${id}`;
    this.at.announce.textContent = "";
    this.showProblem(null);
    this.showProgress({ fraction: 0 });
    this.picture.open(id);
    this.steering.open(id);
    this.listen();
    await this.reload();
  }

  close() {
    this.steering.close();
    this.player.close();
    this.picture.open(null);
    this.at.live.close();
    this.events?.close();
    clearTimeout(this.reloading);
    this.reloading = 0;
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

  // As a live job's camera is moved there is news with each of its pictures, and no time to ask.
  reloadSoon() {
    if (this.reloading) return;
    const { id } = this;
    this.reloading = setTimeout(() => {
      this.reloading = 0;
      if (this.id !== id) return;
      if (this.at.live.isMoving) this.reloadSoon();
      else this.reload();
    }, SOON_MS);
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
    on("snapshot", (job) => { this.revision = undefined; this.show(job); }); // maybe of another life of the server's
    on("progress", (progress) => { this.showProgress(progress); if (this.at.live.progress(progress)) this.reloadSoon(); });
    on("state", (change) => {
      this.state = change.state;
      this.revision = change.revision;
      if (!this.at.live.changed(change)) this.reload();
      else { this.showProgress(change.progress); this.reloadSoon(); }
    });
    on("frame", () => this.reloadSoon());
  }

  // Everything that GET /v1/jobs/{id} says.
  show(job) {
    if (job.id !== this.id) return; // an answer to a change of the job that was left
    // An answer may be older than an event, or another answer, that came before it.
    if (job.revision < this.revision && !ENDED.has(job.state)) return;
    this.revision = job.revision;
    this.state = job.state;
    this.paused = job.paused;
    this.steering.show(job);
    this.at.title.textContent = job.name ?? `Job ${job.id}`;
    this.frame = firstFrame(job.document);
    this.showProgress(job.progress ?? {});
    this.picture.setLook(job.document?.image);
    this.picture.setLayers(job.document?.layers ?? ["beauty"]);
    this.showProblem(job.error ? `${job.error.pointer ? `${job.error.pointer}: ` : ""}${job.error.detail ?? job.error.title}` : null);
    this.player.show(job);
    this.at.live.show(this.id, { ...job, state: this.state });
    this.showDownloads();
    this.at.warnings.replaceChildren(...(job.warnings ?? []).map((text) => textElement("li", text)));
    if (ENDED.has(job.state) && !this.ended) this.end(job);
  }

  end(job) {
    this.ended = true;
    this.events?.close();
    this.at.announce.textContent = `Job ${job.state}`;
  }

  showProgress(progress) {
    const { fraction = 0, tiles_done: done, tiles_total: total } = progress, left = timeLeft({ state: this.state, progress });
    const finished = this.state === "finished" || this.state === "resting";
    const percent = finished ? 100 : percentOf(this.state, fraction);
    this.at.progress.value = percent;
    let text = `${percent} %`;
    if (this.state && !finished) text += ` · ${this.state}${this.paused ? ", paused" : ""}`;
    if (total && !finished && !ENDED.has(this.state)) text += ` · ${done} of ${total} tiles`;
    if (left && !finished) text += ` · ${left}`;
    if (finished) text += this.state === "resting" ? " · complete" : " · finished";
    this.at.progressText.textContent = text;
    if (Math.floor(percent / 10) > this.announced) {
      this.announced = Math.floor(percent / 10);
      this.at.announce.textContent = `${percent} percent`;
    }
  }

  // Of the frame in sight.
  showDownloads() {
    const frame = this.player.number ?? this.frame, there = this.state === "finished" || this.player.done.includes(frame);
    for (const kind of ["exr", "png"]) {
      const link = this.at[`download_${kind}`];
      link.hidden = !there;
      link.href = imageUrl(this.id, frame, kind);
      link.download = `${this.id}${this.player.isSequence ? `.${frame}` : ""}.${kind}`;
    }
  }

  showProblem(text) {
    this.at.problem.hidden = !text;
    this.at.problem.textContent = text ?? "";
  }
}

function textElement(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}

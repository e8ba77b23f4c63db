// The controls that act on a job: cancel, pause, priority, what is rendered first, more samples. What
// they show is what the server has said, never what was asked of it.
import { cancelJob, steerJob } from "../api.js";
import { submitMore } from "./more_samples.js";
import { Region } from "../picture/region.js";

const ENDED = new Set(["finished", "failed", "cancelled"]);
const STEP = 10, HIGHEST = 100; // of priorities
const FOLLOW_MS = 150; // the point is told at most this often
const asText = ({ x, y, width, height }) => `${width} × ${height} pixels at ${x}, ${y}`;

export class Steering {
  // `onJob` gets what the server answers.
  constructor(picture, elements, onJob) {
    this.picture = picture;
    this.at = elements;
    this.onJob = onJob;
    this.region = new Region(picture.viewport, {
      onDrawn: (region) => { this.draw(false); this.first(region); },
      onChange: () => picture.redraw(),
    });
    picture.takesDrag = (kind, x, y) => this.region.drag(kind, x, y);
    picture.areas = () => this.areas();
    picture.onPointed = (point) => this.pointed(point);
    picture.shortcuts.add(this.keys());
    this.bind();
    this.show(null);
  }

  bind() {
    const { at } = this, on = (name, run) => at[name].addEventListener("click", run);
    on("cancel", () => this.askCancel());
    on("cancelYes", () => { at.cancelDialog.close(); this.cancel(); });
    on("cancelNo", () => at.cancelDialog.close());
    on("pause", () => this.pause());
    on("lower", () => this.rank(-STEP));
    on("raise", () => this.rank(STEP));
    on("seen", () => this.firstSeen());
    on("draw", () => this.draw(!this.region.active));
    on("clear", () => this.first(null));
    on("follow", () => this.follow(!this.following));
    on("more", () => this.more());
    addEventListener("pagehide", () => this.follow(false));
  }

  keys() {
    return [
      { keys: ["p"], name: "pause or resume the job", run: () => this.pause() },
      { keys: ["."], name: "raise the job's priority by ten", run: () => this.rank(STEP) },
      { keys: [","], name: "lower it by ten", run: () => this.rank(-STEP) },
      { keys: ["v"], name: "render the visible part first", run: () => this.firstSeen() },
      { keys: ["Shift+v"], shown: ["Shift+V"], name: "render no area first", run: () => this.first(null) },
      { keys: ["a"], name: "draw an area with the mouse that is rendered first (Escape: cancel)", run: () => this.draw(!this.region.active) },
      { keys: ["Escape"], run: () => this.draw(false) },
      { keys: ["n"], name: "render what is near the mouse, or near the selected pixel, first", run: () => this.follow(!this.following) },
      { keys: ["s"], name: "more samples: render the job again with four times as many, over this picture", run: () => this.more() },
      { keys: ["Delete"], name: "cancel the job (asks first)", run: () => this.askCancel() },
    ];
  }

  open(id) {
    this.close();
    this.id = id;
  }

  close() {
    this.follow(false);
    this.region.cancel();
    if (this.at.cancelDialog.open) this.at.cancelDialog.close();
    this.id = null;
    this.problem("");
    this.show(null);
  }

  get going() { return Boolean(this.id && this.job && !ENDED.has(this.job.state)); }

  // What GET and PATCH say; null: nothing yet.
  show(job) {
    const { at } = this;
    this.job = job;
    const { going } = this;
    for (const name of ["cancel", "pause", "lower", "raise", "seen", "draw", "clear", "follow"]) at[name].disabled = !going;
    at.more.disabled = !job;
    at.pause.textContent = job?.paused ? "Resume" : "Pause";
    at.priority.textContent = String(job?.priority ?? 0).replace("-", "−");
    at.lower.disabled ||= job.priority <= -HIGHEST;
    at.raise.disabled ||= job.priority >= HIGHEST;
    at.clear.hidden = !going || !job.region;
    at.region.textContent = going && job.region ? `First: ${asText(job.region)}` : "";
    if (!going) {
      if (this.following) this.follow(false);
      if (this.region.active) this.draw(false);
      if (at.cancelDialog.open) at.cancelDialog.close();
    }
    this.picture.redraw();
  }

  // Rectangles to be drawn over the picture: what goes first, and what is being drawn.
  areas() {
    const drawn = this.region.rectangle(), areas = [];
    if (this.going && this.job.region) areas.push({ ...this.job.region, name: "first" });
    if (drawn) areas.push({ ...drawn, name: `${drawn.width} × ${drawn.height}` });
    return areas;
  }

  // Asks the server, and shows and says what it answers. `words(job)` are said.
  async steer(change, words) {
    const { id } = this;
    if (!this.going) { this.picture.say("The job has ended."); return; }
    this.problem("");
    try {
      const job = await steerJob(id, change);
      if (this.id !== id) return;
      this.onJob(job);
      if (words) this.picture.say(words(job));
    } catch (error) {
      if (this.id === id) this.problem(error.message);
    }
  }

  pause() { return this.steer({ paused: !this.job?.paused }, ({ paused }) => paused ? "Job paused" : "Job resumed"); }

  rank(by) {
    const priority = Math.max(-HIGHEST, Math.min(HIGHEST, (this.job?.priority ?? 0) + by));
    return this.steer({ priority }, (job) => `Priority ${job.priority}`);
  }

  first(region) {
    return this.steer({ region }, (job) => job.region ? `Rendering first: ${asText(job.region)}` : "No area goes first");
  }

  firstSeen() {
    const { x0, y0, x1, y1 } = this.picture.viewport.visible();
    if (x1 > x0 && y1 > y0) this.first({ x: x0, y: y0, width: x1 - x0, height: y1 - y0 });
  }

  draw(active) {
    if (active && !this.going) return;
    if (active === this.region.active) return;
    if (active) this.region.active = true;
    else this.region.cancel();
    this.at.draw.setAttribute("aria-pressed", String(active));
    if (active) this.picture.say("Drag over the picture to draw the area.");
  }

  // Tiles near the mouse first, until it is switched off.
  follow(following) {
    if (following && !this.going) return;
    if (following === Boolean(this.following)) return;
    this.following = following;
    this.at.follow.setAttribute("aria-pressed", String(following));
    if (following) {
      this.told = undefined;
      this.picture.say("Rendering near the mouse first.");
      this.pointed(this.picture.probe.point);
    } else if (this.told) {
      this.told = null;
      if (this.going) steerJob(this.id, { near: null }, true).then((job) => { if (this.id === job.id) this.onJob(job); }, () => {});
    }
  }

  pointed(point) {
    if (!this.following) return;
    const { width, height } = this.picture.viewport.picture;
    const inside = point && point.x >= 0 && point.y >= 0 && point.x < width && point.y < height;
    this.wanted = inside ? { x: point.x, y: point.y } : null;
    if (!this.telling) this.tell();
  }

  // One request at a time, always with the newest point.
  async tell() {
    this.telling = true;
    while (this.following && JSON.stringify(this.wanted) !== JSON.stringify(this.told)) {
      this.told = this.wanted;
      await this.steer({ near: this.wanted });
      await new Promise((done) => setTimeout(done, FOLLOW_MS));
    }
    this.telling = false;
  }

  askCancel() {
    if (this.going && !this.at.cancelDialog.open) this.at.cancelDialog.showModal();
  }

  async cancel() {
    const { id } = this;
    this.problem("");
    try {
      await cancelJob(id);
    } catch (error) {
      if (this.id === id) this.problem(error.message);
    }
  }

  async more() {
    const { id } = this;
    if (!this.job || this.asking) return;
    this.asking = true;
    this.problem("");
    try {
      const job = await submitMore(id);
      if (this.id !== id) return;
      this.picture.keepUnder(job.id);
      location.hash = `#/jobs/${job.id}`;
      this.picture.say(`The job with ${job.document.sampling.target_error > 0 ? "half the error" : `${job.document.sampling.spp} samples per pixel`}, over the previous picture.`);
    } catch (error) {
      if (this.id === id) this.problem(error.message);
    } finally {
      this.asking = false;
    }
  }

  problem(text) { this.at.problem.textContent = text; }
}

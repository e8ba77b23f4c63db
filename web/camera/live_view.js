// Moving a live job's camera on its picture: the mode, its mouse, wheel and keys, the lens, and the
// camera as JSON.
import { getJob, submitJob } from "../api.js";
import { firstFrame } from "../job/progress_text.js";
import { LiveCamera } from "./live_camera.js";
import { distanceAlongView, dolly, orbit, pan, shortest } from "./orbit.js";

const TURN = 5 * Math.PI / 180, STEP = 0.05, NEARER = 0.9; // of a key
const A_DRAG = Math.PI; // turn of a drag over the picture's height
const CALM_MS = 300;
const OPEN = new Set(["running", "resting"]);

export class LiveView {
  // `picture` is the page's PictureView.
  constructor(elements, picture) {
    this.at = elements;
    this.picture = picture;
    this.live = new LiveCamera(() => { this.showState(); if (this.live.settled) picture.redraw(); });
    this.mode = this.focusing = false;
    this.objects = null; // object_mode.js
    picture.toggleCamera = () => { if (!elements.bar.hidden) this.setMode(!this.mode); else picture.say("This job is not live."); };
    picture.cameraDrag = (kind, x, y, event) => this.drag(kind, x, y, event);
    picture.cameraWheel = (event) => this.wheel(event);
    picture.awaitsView = (view) => this.live.awaits(view);
    picture.onViewShown = (number) => this.live.drawn(number);
    picture.shortcuts.before = (event) => this.mode && this.key(event);
    elements.mode.addEventListener("click", () => this.setMode(!this.mode));
    elements.focus.addEventListener("click", () => this.setFocusing(!this.focusing));
    elements.copy.addEventListener("click", () => this.copy());
    elements.make.addEventListener("click", () => this.make());
    for (const input of [elements.aperture, elements.distance]) input.addEventListener("change", () => this.setLens());
    picture.at.canvas.addEventListener("contextmenu", (event) => { if (this.mode) event.preventDefault(); });
  }

  // Whether the first pixels of a move are awaited, or have just appeared.
  get isMoving() { return this.picture.hurrying !== 0; }

  close() {
    this.live.close();
    this.setMode(false);
    this.at.bar.hidden = true;
    this.at.make.hidden = true;
    this.objects?.close();
    this.tell("");
    this.id = this.job = this.depth = null;
  }

  // Everything that GET says of the job that is shown.
  show(id, job) {
    const live = job.document?.live === true;
    this.at.make.hidden = live || !job.document;
    if (!live) { this.at.bar.hidden = true; this.objects?.close(); return; }
    this.job = job;
    this.id = id;
    this.at.bar.hidden = !OPEN.has(job.state);
    if (this.at.bar.hidden) this.setMode(false);
    this.hasDepth = job.document.layers.includes("depth");
    this.live.take(id, job, 4 * (job.plan?.length_unit ?? 1));
    this.objects?.show(this.at.bar.hidden ? null : job);
    this.tell(job.state);
  }

  // What an event says: another page may have moved it.
  progress({ view }) {
    if (!view || !this.id) return false;
    if (!view.complete) this.tell("running");
    return view.number > this.live.number && this.live.settled;
  }

  // A change of state by a move, or the end of one: there is nothing else to be asked for.
  changed({ state, progress }) {
    const known = Boolean(this.id) && OPEN.has(state) && (progress?.view?.number ?? 0) <= this.live.number;
    if (known) this.tell(state);
    return known;
  }

  // Announces "complete" when the picture stays so for a moment and there is no drag. So a drag is one
  // "refining" and one "complete", whatever is complete in between.
  tell(state) {
    const say = (text) => { if (this.at.state.textContent !== text) this.at.state.textContent = text; };
    clearTimeout(this.saying);
    if (state !== "resting") { say(state === "running" ? "refining" : ""); return; }
    this.saying = setTimeout(() => { if (this.held || this.objects?.held) this.tell(state); else say("complete"); }, CALM_MS);
  }

  // It stays until the next move succeeds, whatever is shown meanwhile.
  complain(text) {
    this.live.problem = text;
    this.at.problem.textContent = text;
  }

  showState() {
    const { at, live } = this, { lens } = live;
    at.problem.textContent = live.problem;
    at.copy.disabled = at.mode.disabled = !live.camera;
    for (const [input, value] of [[at.aperture, lens?.aperture_radius ?? 0], [at.distance, lens?.focus_distance ?? ""]])
      if (document.activeElement !== input || !at.bar.contains(input)) input.value = String(value);
    this.objects?.showState();
    at.bar.dataset.view = String(live.number);
    at.bar.dataset.settled = String(live.settled);
    at.bar.dataset.firstPixels = live.firstPixels.map((ms) => ms.toFixed(1)).join(" ");
  }

  setMode(on) {
    if (on && !this.live.camera) return;
    if (on) this.objects?.setMode(false);
    if (on !== this.mode) this.picture.say(on ? "camera mode" : "picture mode");
    this.mode = on;
    this.at.mode.setAttribute("aria-pressed", String(on));
    this.picture.at.stage.dataset.mode = on ? "camera" : "";
    if (!on) this.setFocusing(false);
    else this.findTarget();
  }

  setFocusing(on) {
    if (on && !this.hasDepth) { this.complain("Picking focus needs the layer depth, which this job does not have."); return; }
    this.focusing = on;
    this.at.focus.setAttribute("aria-pressed", String(on));
    if (on) this.followDepth();
    else this.leaveDepth();
  }

  followDepth() {
    this.depth = this.picture.sources.get(this.id, "depth");
    if (!this.depth.stopFeed) this.depth.follow(() => {}, () => {});
  }

  // Leaves a feed that is not looked at, which would only cost time.
  leaveDepth() {
    const { depth, picture } = this;
    if (depth && !this.focusing && depth !== picture.source && depth !== picture.other) depth.stop();
    if (!this.focusing) this.depth = null;
  }

  // The depth of a pixel of the view in sight, once it is there; null when there is no surface.
  async depthAt(x, y) {
    const { id } = this;
    let value;
    this.followDepth();
    for (let i = 0; i < 100 && value === undefined && this.id === id; i++) {
      const { image } = this.depth;
      if (image.view >= this.live.number) value = image.at(x, y)?.[0];
      if (value === undefined) await new Promise((done) => setTimeout(done, 20));
    }
    if (this.id === id) this.leaveDepth();
    return value > 0 ? value : null;
  }

  // A camera of the scene has no target: what it looks at in the middle is a good one.
  async findTarget() {
    const { live, id, job } = this;
    if (!this.hasDepth || !live.camera || job.document.scene.camera?.eye || live.number > (job.view?.number ?? 0)) return;
    const { width, height } = job.document.image, before = live.camera;
    const depth = await this.depthAt(width >> 1, height >> 1);
    if (depth === null || this.id !== id || live.camera !== before) return;
    live.camera = { ...before, target: before.eye.map((v, i) => v + job.plan.camera.forward[i] * depth) };
  }

  // `event`: the input, from whose time the delay is measured.
  go(camera, event) { if (this.live.camera) this.change({ camera }, event.timeStamp); }

  change(change, at) {
    this.picture.hurry();
    this.live.move(change, at);
    this.tell("running");
  }

  drag(kind, x, y, event) {
    const { live, picture } = this, { camera } = live;
    if (kind === "down") {
      if (!this.mode || !camera) return false;
      event.preventDefault();
      this.held = { x, y, how: this.focusing ? "focus" : event.button === 2 ? "dolly" : event.button === 1 || event.shiftKey ? "pan" : "orbit" };
      return true;
    }
    if (!this.held) return false;
    const dx = x - this.held.x, dy = y - this.held.y, tall = picture.viewport.picture.height * picture.viewport.zoom;
    if (kind === "up") {
      if (this.held.how === "focus") this.pickFocus(picture.viewport.toPicture(x, y));
      this.held = null;
    } else if (this.held.how !== "focus") {
      this.held = { ...this.held, x, y };
      if (this.held.how === "orbit") this.go(orbit(camera, -dx / tall * A_DRAG, dy / tall * A_DRAG), event);
      else if (this.held.how === "pan") this.go(pan(camera, -dx / tall, dy / tall), event);
      else this.go(dolly(camera, 2 ** (dy / tall * 2)), event);
    }
    return true;
  }

  // With Ctrl or Alt the wheel brings the camera nearer; without it zooms the picture, as ever.
  wheel(event) {
    if (!this.mode || !this.live.camera || !(event.ctrlKey || event.altKey)) return false;
    this.go(dolly(this.live.camera, 2 ** (Math.max(-200, Math.min(200, event.deltaY)) / 400)), event);
    return true;
  }

  key(event) {
    const { camera } = this.live, { shiftKey: shift } = event;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.key === "Escape") { this.setMode(false); return true; }
    if (!camera) return false;
    if (arrows[event.key]) {
      const [right, over] = arrows[event.key];
      this.go(shift ? pan(camera, right * STEP, over * STEP) : orbit(camera, right * TURN, over * TURN), event);
    } else if (event.key === "+" || event.key === "=") this.go(dolly(camera, NEARER), event);
    else if (event.key === "-") this.go(dolly(camera, 1 / NEARER), event);
    else if (event.key.toLowerCase() === "f") this.pickFocusAtPoint();
    else if (event.key.toLowerCase() === "j") this.copy();
    else return false;
    return true;
  }

  // Where the mouse or the probe points, else the middle.
  pickFocusAtPoint() {
    const { point } = this.picture.probe, { width, height } = this.job.document.image;
    this.pickFocus(point ?? { x: width >> 1, y: height >> 1 });
  }

  async pickFocus({ x, y }) {
    const { at, live, job, id } = this, { width, height } = job.document.image;
    const px = Math.floor(x), py = Math.floor(y);
    if (!this.hasDepth) { this.setFocusing(true); return; }
    if (px < 0 || py < 0 || px >= width || py >= height) return;
    const depth = await this.depthAt(px, py);
    if (this.id !== id || !live.camera) return;
    if (depth === null) { this.picture.say("There is no surface to focus on."); return; }
    const distance = shortest(distanceAlongView(depth, px, py, { width, height }, live.camera.yfov_deg));
    at.distance.value = String(distance);
    this.setFocusing(false);
    this.picture.say(`focus at ${Number(distance.toPrecision(4))}${live.lens ? "" : ": set an aperture to use it"}`);
    if (live.lens) this.setLens();
  }

  setLens() {
    const { at, live } = this, radius = Number(at.aperture.value), distance = Number(at.distance.value);
    if (!live.camera) return;
    if (!(radius > 0)) { if (live.lens) this.change({ lens: null }); return; }
    if (!(distance > 0)) { this.complain("Enter a focus distance, or pick focus in the picture."); return; }
    this.change({ lens: { blades: live.lens?.blades ?? 0, blade_rotation_deg: live.lens?.blade_rotation_deg ?? 0, aperture_radius: radius, focus_distance: distance } });
  }

  // The camera as the server has it: what a job document takes as scene.camera.
  async copy() {
    while (!this.live.settled) await new Promise((done) => setTimeout(done, 10));
    const text = JSON.stringify(this.live.camera);
    try {
      await navigator.clipboard.writeText(text);
      this.picture.say("camera copied");
    } catch {
      this.at.problem.textContent = `The browser allows no clipboard. The camera: ${text}`;
    }
  }

  // A live job of the same document, with depths to focus by, or with the photograph beside the composite.
  async make() {
    const id = location.hash.split("/").pop();
    try {
      const { document } = await getJob(id), { target_error, max_spp, ...sampling } = document.sampling;
      const first = firstFrame(document), layers = [...new Set([...document.layers, document.backplate ? "backplate" : "depth"])];
      const made = await submitJob({ ...document, sampling, layers, frames: { first, last: first }, live: true }, `live-${id}-${Date.now()}`);
      location.hash = `#/jobs/${made.id}`;
    } catch (error) { this.at.makeProblem(error.message); }
  }
}

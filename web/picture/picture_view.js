// The picture and all that looks at it: layers, zoom, display, comparison, probe, histogram.
import { CanvasNote } from "./canvas_note.js";
import { Compare, differenceOf, sideNames } from "../compare/compare.js";
import { chooseOtherFile, chooseOtherJob, showUnfiltered } from "../compare/other_choice.js";
import { Display } from "./display.js";
import { Flicker } from "../sequence/flicker.js";
import { FrameCache } from "../sequence/frame_cache.js";
import { setText } from "../elements.js";
import { Gestures } from "./gestures.js";
import { Histogram } from "./histogram.js";
import { PerceptualMetrics } from "../compare/perceptual_metrics.js";
import { PerceptualView } from "../compare/perceptual_view.js";
import { sparseStep } from "./layer_image.js";
import { LayerSources } from "./layer_source.js";
import { Picture } from "./picture.js";
import { pictureKeys } from "./picture_keys.js";
import { Probe } from "./probe.js";
import { Shortcuts } from "../shortcuts.js";
import { ValueOverlay } from "./value_overlay.js";
import { Viewport } from "./viewport.js";

const SCALARS = new Set(["depth", "samples", "filter_width", "visibility", "slope_min", "slope_max", "occlusion", "id"]);
const NOT_PICTURES = new Set([...SCALARS, "normal", "error"]); // nothing that is looked at as it is
const MEASURE_MS = 250; // figures, histogram and ranges follow at most this often
const HURRY_MS = 300; // after the last move of a camera

export class PictureView {
  constructor(elements, onFeedState) {
    this.at = elements;
    this.onFeedState = onFeedState;
    this.layers = [];
    this.source = this.other = null;
    this.hurrying = 0; // the timer of its end
    // For the steering of the job: drags that it takes, areas that it shows, the pixel pointed at.
    this.takesDrag = () => false;
    this.areas = () => [];
    this.onPointed = () => {};
    // For the moving camera: whether another view than the visible one is due.
    this.awaitsView = () => false;
    // For the player: the number of the frame before the one in sight.
    this.frameBefore = () => null;
    this.isSequence = false;
    const redraw = () => this.redraw();
    this.note = new CanvasNote(elements.note);
    this.viewport = new Viewport(redraw);
    this.compare = new Compare(() => { this.showCompare(); redraw(); });
    this.display = new Display(elements, () => { this.measureSoon(); redraw(); });
    this.probe = new Probe({ readout: elements.readout, list: elements.pins }, () => { this.onPointed(this.probe.point); redraw(); });
    this.histogram = new Histogram(elements.histogram, elements.histogramText);
    this.overlay = new ValueOverlay(elements.overlay);
    this.metrics = new PerceptualMetrics(() => { this.measureSoon(); redraw(); }, (image) => this.picture?.forget(image));
    this.perceptual = new PerceptualView(elements, this.metrics);
    this.probe.more = (point) => this.flicker.describe(point) + (this.compare.mode === "off" ? "" : this.perceptual.describe(point));
    const onForget = ({ image }) => this.picture?.forget(image);
    this.sources = new LayerSources(onForget);
    this.frames = new FrameCache({ onForget, onBlock: (source) => this.took(source), onWhole: (source) => this.tookFrame(source),
      isSeen: (source) => source === this.source || source === this.other });
    this.flicker = new Flicker(elements, { frames: this.frames, onChange: () => { this.measureSoon(); redraw(); }, say: (text) => this.say(text),
      onForget: (image) => this.picture?.forget(image) });
    try {
      this.picture = new Picture(elements.canvas, () => this.look());
      this.picture.onError = (error) => this.note.set({ fault: error.message });
      this.picture.onLost = (lost) => this.note.set({ lost });
      this.note.set({ lost: this.picture.lost });
      this.picture.onDrawn = () => this.drawn();
      this.picture.onShown = () => this.onViewShown?.(this.viewDrawn);
    } catch (error) {
      this.note.set({ fault: error.message });
    }
    this.gestures = new Gestures(elements.canvas, this.viewport, {
      onDrag: (kind, x, y, event) => this.cameraDrag?.(kind, x, y, event) ||
        (event.button === 0 || kind !== "down") && (this.takesDrag(kind, x, y) ||
          this.compare.drag(kind, x, y, this.viewport.canvas.width, this.viewport.canvas.height, this.ratio)),
      onWheel: (event) => this.cameraWheel?.(event) === true,
      onPoint: (x, y) => this.probe.set(x === null ? null : this.viewport.toPicture(x, y)),
      onClick: (x, y) => { this.probe.set(this.viewport.toPicture(x, y)); this.probe.pin(); },
    });
    this.shortcuts = new Shortcuts(elements.stage, pictureKeys(this), elements.sheet);
    this.bind();
    new ResizeObserver((entries) => this.resize(entries[0])).observe(elements.stage);
  }

  bind() {
    const { at } = this;
    at.layer.addEventListener("change", () => this.setLayer(at.layer.value));
    at.compare.addEventListener("change", () => this.setCompare(at.compare.value));
    at.otherLayer.addEventListener("change", () => this.followOther());
    at.otherBefore.addEventListener("change", () => this.setBefore(at.otherBefore.checked));
    at.otherJob.addEventListener("change", () => chooseOtherJob(this));
    at.otherFile.addEventListener("change", () => chooseOtherFile(this, at.otherFile.files[0]));
    at.stage.addEventListener("dragover", (event) => event.preventDefault());
    at.stage.addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer.files.length > 0) chooseOtherFile(this, event.dataTransfer.files[0]);
    });
    for (const name of ["position", "angle"])
      at[name].addEventListener("input", () => this.compare.set({ [name]: Number(at[name].value) / (name === "position" ? 100 : 1) }));
    at.flip.addEventListener("click", () => this.flip());
    at.unfiltered.addEventListener("click", () => showUnfiltered(this));
    at.fit.addEventListener("click", () => this.viewport.fit());
    at.actual.addEventListener("click", () => this.viewport.zoomTo(1));
    at.zoomIn.addEventListener("click", () => this.viewport.zoomBy(2));
    at.zoomOut.addEventListener("click", () => this.viewport.zoomBy(0.5));
  }

  resize({ contentRect }) {
    this.ratio = devicePixelRatio || 1;
    const width = Math.round(contentRect.width * this.ratio), height = Math.round(contentRect.height * this.ratio);
    if (width === 0 || height === 0) return;
    Object.assign(this.at.overlay, { width, height }); // the picture sees to its own
    this.overlay.clear = true;
    this.viewport.setCanvas(width, height);
  }

  // Shows a job's layers from nothing; null: no job.
  open(job) {
    if (job && this.under?.job !== job) this.under = null;
    this.sources.clear();
    this.flicker.stop();
    this.frames.open(job);
    this.source = this.other = this.frame = null;
    this.job = job;
    this.layers = [];
    delete this.at.canvas.dataset.view;
    if (!this.under) this.viewport.setPicture(0, 0);
    this.note.set({ refusal: "", fault: this.picture ? "" : this.note.fault });
    this.at.otherJob.value = this.at.otherFile.value = "";
    this.at.otherBefore.checked = false;
    this.otherJob = this.otherFile = null;
    this.compare.set({ mode: "off", flipped: false });
    this.metrics.clear();
    this.probe.clear();
    if (job) this.setLayer(this.under?.layer ?? "beauty");
  }

  // The picture of now stays under that of the job, block by block until its own are there.
  keepUnder(job) {
    if (!this.source) return;
    const images = new Map([...this.sources.of(this.job)].map(({ layer, image }) => [layer, image]));
    this.under = { job, of: this.job, layer: this.source.layer, images };
  }

  showUnder() {
    const { under, source } = this, shown = under && under.images.has(source.layer) && !source.image.isWhole();
    this.at.underText.hidden = !shown;
    const text = shown ? `Blocks that are not drawn yet show job ${under.of.slice(-6)}.` : "";
    if (this.at.underText.textContent !== text) this.at.underText.textContent = text;
  }

  // How the job's document says that its picture is seen, once: what the person chooses then stays. A
  // picture that goes on in another job is seen as before.
  setLook(image = {}) {
    if (this.lookOf === this.job) return;
    this.lookOf = this.job;
    if (!this.under) this.display.ask(image);
  }

  // The names of the job's layers.
  setLayers(names) {
    if (names.join() === this.layers.join()) return;
    const first = this.layers.length === 0;
    this.layers = names;
    if (first && this.source?.layer === "beauty" && names.includes("composite")) this.setLayer("composite");
    this.fill(this.at.layer, names, this.source?.layer);
    if (!this.otherJob && !this.otherFile) this.fill(this.at.otherLayer, names, names.find((name) => name !== this.source?.layer));
    if (this.source && !names.includes(this.source.layer)) this.setLayer(names[0]);
  }

  fill(select, names, chosen) {
    select.replaceChildren(...names.map((name) => new Option(name.replaceAll("_", " "), name, false, name === chosen)));
  }

  // The layer of the frame that is looked at: of a finished one, or of what the feed shows (null).
  sourceOf(layer, frame = this.frame, job = this.job) { return frame === null ? this.sources.get(job, layer) : this.frames.get(layer, frame, job); }

  showFrame(frame) {
    if (frame === this.frame) return;
    this.frame = frame;
    this.setLayer(this.source.layer);
  }

  // It is not looked at any more. Of frames the GPU has those in sight alone.
  leave(source) {
    source?.stop();
    if (source && source.frame !== null) this.picture?.forget(source.image);
  }

  setLayer(layer) {
    const before = this.source;
    this.flicker.stop();
    this.source = this.sourceOf(layer);
    if (before !== this.other && before !== this.source) this.leave(before);
    if (this.under?.images.has(layer)) this.source.image.showOver(this.under.images.get(layer));
    this.at.layer.value = layer;
    this.note.set({ refusal: "" });
    this.display.setLayer(layer);
    this.follow(this.source);
    if (this.compare.mode !== "off") this.followOther();
    this.redraw();
  }

  stepLayer(by) {
    const { length } = this.layers;
    if (length === 0) return;
    this.setLayer(this.layers[(this.layers.indexOf(this.source.layer) + by + length) % length]);
    this.say(this.source.layer);
  }

  follow(source) {
    if (!this.picture || source.stopFeed || source.frame !== null) {
      if (source.frame !== null) this.frames.load(source);
      this.measureSoon();
      return;
    }
    source.follow(() => this.took(source), (state, error) => {
      this.onFeedState(state, error);
      if (state === "refused") this.noteRefused(source, error);
      if (state === "still") this.measureSoon();
    });
    if (source.image.width > 0) this.viewport.setPicture(source.image.width, source.image.height);
    this.measureSoon();
  }

  // Pixels have come.
  took(source) {
    const { image } = source;
    if (source === this.source) this.viewport.setPicture(image.width, image.height);
    else if (source !== this.other) return;
    this.measureSoon();
    if (source !== this.source || !this.awaitsView(image.view)) this.redraw();
  }

  // All of a frame is there, or it cannot be had.
  tookFrame(source) {
    if (source === this.other) this.at.otherProblem.textContent = source.fault?.message ?? "";
    this.measureSoon();
    this.onFrameWhole?.();
  }

  setCompare(mode) {
    if (mode === "off" || !this.source) this.stopOther();
    else if (mode === "onion" && this.isSequence && !this.otherJob && !this.otherFile) this.setBefore(true);
    this.compare.set({ mode, flipped: false });
    if (mode !== "off") this.followOther();
  }

  followOther() {
    if (this.compare.mode === "off" || !this.at.otherLayer.value) return;
    const layer = this.at.otherLayer.value;
    if (this.otherFile && this.other?.job === this.otherFile.name && this.other.layer === layer) return;
    const frame = this.at.otherBefore.checked ? this.frameBefore() ?? this.frame : this.frame;
    const next = this.otherFile ? this.otherFile.source(layer) : this.sourceOf(layer, frame, this.otherJob ?? this.job);
    if (next !== this.other) this.stopOther();
    this.other = next;
    this.follow(next);
    this.showCompare();
    this.redraw();
  }

  // The job has several frames, of which the other of two may be the one before.
  setSequence(on) {
    this.isSequence = on;
    this.at.otherBeforeLabel.hidden = !on;
  }

  // The other is of the frame before.
  setBefore(on) {
    const { at } = this;
    at.otherBefore.checked = on;
    if (on) {
      this.stopOther();
      this.otherJob = this.otherFile = null;
      at.otherJob.value = at.otherFile.value = "";
      this.fill(at.otherLayer, this.layers, this.source.layer);
    }
    this.followOther();
  }

  stopOther() {
    if (this.other !== this.source) this.leave(this.other);
    if (this.otherFile?.name === this.other?.job) this.picture?.forget(this.other?.image);
    this.other = null;
  }

  flip() {
    if (this.compare.mode !== "toggle") this.setCompare("toggle");
    this.compare.set({ flipped: !this.compare.flipped });
    this.say(this.compare.flipped ? `other: ${this.other?.layer ?? "none"}` : this.source?.layer ?? "");
  }

  showCompare() {
    const { at, compare } = this;
    at.compare.value = compare.mode;
    at.others.hidden = compare.mode === "off";
    at.wipe.hidden = compare.mode !== "wipe";
    at.flip.hidden = compare.mode !== "toggle";
    at.flip.setAttribute("aria-pressed", String(compare.flipped));
    at.position.value = String(Math.round(compare.position * 100));
    at.angle.value = String(compare.angle);
    this.measureSoon();
  }

  look() {
    const map = this.flicker.look(this.viewport) ?? this.perceptual.look(this.compare, this.viewport);
    return map ?? { first: this.source?.image, other: this.other?.image, viewport: this.viewport, display: this.display, compare: this.compare, hurried: this.hurrying !== 0 };
  }

  // The camera is being moved: the next picture's first pixels go before all else for a moment.
  hurry() {
    clearTimeout(this.hurrying);
    this.hurrying = setTimeout(() => { this.hurrying = 0; this.measureSoon(); this.redraw(); }, HURRY_MS);
  }

  redraw() { this.picture?.draw(); }

  // After a drawing: what lies over it.
  drawn() {
    const { at, viewport, source, other } = this;
    if (!source) return;
    at.behindLabel.hidden = !source.image.alpha && !(this.compare.mode !== "off" && other?.image.alpha);
    const map = this.flicker.values() ?? this.perceptual.values(this.compare);
    const scalar = SCALARS.has(source.layer), shown = this.compare.shown === "other" && other ? other : source;
    this.showUnder();
    this.overlay.draw({ image: map ?? shown.image, viewport, areas: this.areas(), names: this.flicker.image ? [] : sideNames(this), marks: this.probe.marks(), scalar: map !== null || SCALARS.has(shown.layer), ratio: this.ratio });
    this.viewDrawn = source.image.view;
    this.probe.show(source.image, this.compare.mode === "off" ? null : other?.image, scalar);
    setText(at.zoomText, `${Number((viewport.zoom * 100).toPrecision(3))} %`);
    const { zoom, x, y } = viewport, view = [zoom, x, y, viewport.picture.width, viewport.picture.height].join(" ");
    if (at.canvas.dataset.view !== view) at.canvas.dataset.view = view;
    if (zoom !== this.measured?.zoom || x !== this.measured?.x || y !== this.measured?.y) this.measureSoon();
  }

  measureSoon() {
    if (this.measuring || this.hurrying || !this.source) return;
    this.measuring = setTimeout(() => { this.measuring = 0; this.measure(); }, MEASURE_MS);
  }

  measure() {
    const { source, other, viewport, display, at } = this;
    if (!source || this.hurrying) return; // its end measures
    const { zoom, x, y } = viewport, moved = zoom !== this.measured?.zoom || x !== this.measured?.x || y !== this.measured?.y;
    this.measured = { zoom, x, y };
    const looked = this.compare.mode === "difference" && other?.image.numbers ? differenceOf(source.image, other.image) : source.image;
    const ranged = [source.layer, display.shownAs, display.auto, display.logarithmic, this.compare.mode].join();
    if (source.frame === null || this.ranged !== ranged) display.measure(looked); // frames have one range
    this.ranged = source.frame !== null && source.whole ? ranged : "";
    if (this.compare.mode !== "off" && other) this.showFigures(moved);
    else at.figures.textContent = "";
    this.showPerceptual(moved);
    this.flicker.show();
    const flicker = this.flicker.look(viewport), map = this.perceptual.look(this.compare, viewport);
    if (flicker) this.histogram.draw(flicker.first, viewport.visible(), flicker.display, true, "Flicker: ");
    else if (map) this.histogram.draw(map.first, { x0: 0, y0: 0, x1: map.first.width, y1: map.first.height }, map.display, true, `${this.compare.metric === "ssim" ? "1 − SSIM" : "FLIP"}: `);
    else this.histogram.draw(looked, viewport.visible(), display, SCALARS.has(source.layer));
    this.redraw();
  }

  // All pixels in sight are counted once nothing changes any more; some until then.
  showFigures(moved) {
    const { source, other, viewport } = this, area = viewport.visible(), live = source.live || other.live;
    const step = moved || live ? sparseStep(area) : 1;
    const found = this.compare.figures(source.image, other.image, area, step);
    if (moved && step > 1) this.measureSoon();
    this.at.figures.textContent = found
      ? `RMSE ${found.rmse.toPrecision(4)}, relMSE ${found.relmse.toPrecision(4)} over ${found.pixels}${step > 1 ? " of the" : ""} pixels in sight${live ? " so far" : ""}${found.bad ? `, ${found.bad} not finite` : ""}`
      : other.image.width && other.image.width !== source.image.width ? "The two have different sizes." : "";
  }

  // Measures once the view rests; while pictures still come, now and then.
  showPerceptual(moved) {
    const { source, other, viewport, display, compare } = this;
    if (compare.mode === "off" || !other) this.metrics.clear();
    else if (!NOT_PICTURES.has(source.layer) && moved) this.measureSoon();
    else if (!NOT_PICTURES.has(source.layer)) this.metrics.measure(source.image, other.image, viewport.visible(), display, source.live || other.live);
    else this.metrics.clear();
    this.perceptual.show(compare, source.live || other?.live, compare.mode !== "off" && other && NOT_PICTURES.has(source.layer));
  }

  say(text) { this.at.said.textContent = text; }

  noteRefused({ layer }, error) {
    this.note.set({ refusal: `The layer ${layer.replaceAll("_", " ")} cannot be shown: ${error.message}` });
  }
}

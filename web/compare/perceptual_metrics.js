// SSIM and FLIP of the visible part of two layers, computed by a web worker, and their maps.
import { LayerImage } from "../picture/layer_image.js";

const MOST_PIXELS = 1 << 22; // in sight: beyond it memory and minutes go
const AGAIN_MS = 2000; // while pictures still come

// The area's numbers of a layer as a worker takes them: {numbers, seen}, in buffers of their own.
function cut(image, { x0, y0, x1, y1 }) {
  const width = x1 - x0, numbers = new image.numbers.constructor(width * (y1 - y0) * 3), seen = new Uint8Array(width * (y1 - y0));
  for (let y = y0; y < y1; y++) {
    const at = (y * image.width + x0) * 3, row = (y - y0) * width;
    numbers.set(image.numbers.subarray(at, at + width * 3), row * 3);
    for (let x = x0; x < x1;) {
      const end = Math.min(x1, (x >> 6) + 1 << 6); // one block after the other
      if (image.has(x, y)) seen.fill(1, row + x - x0, row + end - x0);
      x = end;
    }
  }
  return { numbers, seen };
}

// A map as a layer: what is unlike is bright, in both.
function mapImage(map, { x0, y0, x1, y1 }, of) {
  const image = new LayerImage(), w = x1 - x0, h = y1 - y0, numbers = new Float32Array(w * h * 3);
  for (let i = 0; i < map.length; i++) numbers.fill(of(map[i]), i * 3, i * 3 + 3);
  image.resize(w, h);
  image.put({ x: 0, y: 0, w, h, numbers });
  return image;
}

export class PerceptualMetrics {
  // Calls `onChange()` when there are new figures, and `onForget(image)` for each map that is gone.
  constructor(onChange, onForget) {
    Object.assign(this, { onChange, onForget, found: null, asked: "", wanted: "", turn: 0, busy: false, at: 0 });
  }

  // Measures the two as they are now. `live`: more of their pixels will come.
  measure(first, other, area, { exposure, gamma, curve }, live) {
    const { width, height, numbers } = first, pixels = (area.x1 - area.x0) * (area.y1 - area.y0);
    if (!numbers || !other.numbers || width !== other.width || height !== other.height || pixels === 0) { this.clear(); return; }
    this.tooMany = pixels > MOST_PIXELS;
    if (this.tooMany) { this.forget(); return; }
    const asked = this.wanted = [first.version, other.version, ...Object.values(area), exposure, gamma, curve].join();
    if (this.first === first && this.other === other && this.asked === asked) return;
    clearTimeout(this.later);
    if (this.busy) return; // its answer asks again
    const wait = live ? this.at + AGAIN_MS - performance.now() : 0;
    if (wait > 0) { this.later = setTimeout(() => this.onChange(), wait); return; }
    Object.assign(this, { first, other, asked, area, busy: true, at: performance.now() });
    const message = { turn: ++this.turn, width: area.x1 - area.x0, height: area.y1 - area.y0, first: cut(first, area), other: cut(other, area), view: { exposure, gamma, curve } };
    this.send(message, [message.first, message.other].flatMap((one) => [one.numbers.buffer, one.seen.buffer]));
  }

  send(message, buffers) {
    if (!this.worker) {
      this.worker = new Worker(new URL("./perceptual_worker.js", import.meta.url), { type: "module" });
      this.worker.addEventListener("message", ({ data }) => this.take(data));
      this.worker.addEventListener("error", () => { this.busy = false; this.failed = true; this.onChange(); });
    }
    this.worker.postMessage(message, buffers);
  }

  take({ turn, count, ssim, flip }) {
    this.busy = false;
    if (turn === this.turn && this.asked) {
      this.forget();
      const { asked, area } = this;
      this.found = { asked, area, count, ssim: ssim.mean, flip, maps: {
        ssim: mapImage(ssim.map, area, (v) => 1 - v), flip: mapImage(flip.map, area, (v) => v) }, values: { ssim: ssim.map, flip: flip.map } };
    }
    this.onChange();
  }

  // Returns a metric at the picture's pixel; null where it was not measured.
  valueAt(metric, { x, y }) {
    const { area, values } = this.found ?? {};
    if (!area || x < area.x0 || y < area.y0 || x >= area.x1 || y >= area.y1) return null;
    return values[metric][(y - area.y0) * (area.x1 - area.x0) + x - area.x0];
  }

  // Whether the figures are those of the two as they are now.
  get current() { return this.found !== null && this.found.asked === this.wanted; }

  forget() {
    for (const image of Object.values(this.found?.maps ?? {})) this.onForget(image);
    this.found = null;
  }

  // Comparing has ended, and the worker's memory goes, too.
  clear() {
    clearTimeout(this.later);
    this.forget();
    this.worker?.terminate();
    Object.assign(this, { worker: null, busy: false, asked: "", wanted: "", first: null, other: null, tooMany: false, failed: false });
  }
}

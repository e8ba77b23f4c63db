// Finished frames of a sequence: one layer of each, fetched before it is shown. What is kept is bounded
// by its bytes, whatever the length of the sequence.
import { LayerSource } from "../picture/layer_source.js";

export const MOST_BYTES = 512 << 20; // of pixels; at least the two that an onion shows
const AT_ONCE = 2; // the server opens as many files
const LEAST = 2;

const bytesOf = ({ image }) => (image.numbers?.byteLength ?? 0) + (image.alpha?.byteLength ?? 0);

export class FrameCache {
  // `onBlock(source)` when pixels have come, `onWhole(source)` when a frame is there or cannot be had,
  // `onForget(source)`; `isSeen(source)`: it is in sight and stays.
  constructor({ onBlock, onWhole, onForget, isSeen }) {
    Object.assign(this, { onBlock, onWhole, onForget, isSeen, job: null, kept: new Map(), wanted: [] });
  }

  open(job) {
    this.wanted = [];
    for (const name of [...this.kept.keys()]) this.forget(name);
    this.job = job;
  }

  get(layer, frame, job = this.job) {
    const name = `${job} ${layer} ${frame}`;
    if (!this.kept.has(name)) this.kept.set(name, new LayerSource(job, layer, frame));
    return this.kept.get(name);
  }

  // The source of a frame that is there; null of others.
  whole(layer, frame) {
    const source = this.kept.get(`${this.job} ${layer} ${frame}`);
    return source?.whole ? source : null;
  }

  // How many frames of the size of the largest there is may be kept.
  get room() {
    const size = Math.max(0, ...[...this.kept.values()].map(bytesOf));
    return size > 0 ? Math.max(LEAST, Math.floor(MOST_BYTES / size)) : LEAST;
  }

  // Fetches these frames, the first first, as many as there is room for; all others go.
  want(layer, frames) {
    const { room } = this, names = new Set();
    this.wanted = [];
    for (const frame of frames) {
      if (this.wanted.length === room) break;
      this.wanted.push(this.get(layer, frame));
      names.add(`${this.job} ${layer} ${frame}`);
    }
    for (const [name, source] of this.kept)
      if (!names.has(name) && !this.isSeen(source)) this.forget(name);
    this.fill();
  }

  fill() {
    let busy = [...this.kept.values()].filter(({ live }) => live).length;
    for (const source of this.wanted) {
      if (busy >= AT_ONCE) break;
      if (!source.whole && !source.live && !source.fault) { this.load(source); busy++; }
    }
  }

  load(source) {
    if (source.whole || source.live) return;
    source.fault = null;
    source.follow(this.onBlock, (state, error) => {
      if (state === "refused") source.fault = error;
      if (state !== "still") return;
      this.fill();
      this.onWhole(source);
    });
  }

  forget(name) {
    const source = this.kept.get(name);
    source.stop();
    this.kept.delete(name);
    this.onForget(source);
  }
}

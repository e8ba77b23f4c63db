// What does not stand still in a sequence: the mean absolute change of each pixel from one frame to the next,
// over all frames that are done. Frames are fetched one after the other; two of them and the map are in
// memory, beside what the player keeps.
import { Compare } from "../compare/compare.js";
import { MAP_DISPLAY } from "../compare/perceptual_view.js";
import { setText } from "../elements.js";
import { LayerImage } from "../picture/layer_image.js";
import { LayerSource } from "../picture/layer_source.js";
import { short } from "../picture/value_overlay.js";

const LOOKED_AT = 20000; // numbers, for the range
const ALONE = new Compare(() => {}); // nothing is compared

// Resolves to the image of a source when all of it is there.
const wholeOf = (source) => new Promise((done, fail) => {
  let fault = new Error("The frame has no picture.");
  source.follow(() => {}, (state, error) => {
    if (state === "refused") fault = error;
    if (state === "still" && source.whole) done(source.image);
    else if (state === "still") fail(fault);
  });
});

// Takes one more pair of frames into the means. What is not finite makes its pixel so.
export function addChange(mean, before, now, pairs) {
  const a = before.reader(), b = now.reader();
  for (let i = 0; i < mean.length; i++) mean[i] += (Math.abs(b(i) - a(i)) - mean[i]) / pairs;
}

export class Flicker {
  // `frames`: the FrameCache, whose frames are not fetched again. `onChange()` when the map has changed,
  // `onForget(image)` when it is gone.
  constructor({ flicker, flickerText, legend, legendEnds }, { frames, onChange, onForget, say }) {
    Object.assign(this, { at: { flicker, flickerText, legend, legendEnds }, frames, onChange, onForget, say, image: null, turn: null });
  }

  get on() { return this.turn !== null; }

  // Of these frames of the cache's job.
  async start(layer, numbers) {
    this.stop();
    const turn = this.turn = {}, { job } = this.frames;
    this.total = numbers.length - 1;
    this.pairs = 0;
    this.show();
    try {
      let before = null;
      for (const number of numbers) {
        const known = this.frames.whole(layer, number);
        this.source = known ? null : new LayerSource(job, layer, number);
        const now = known?.image ?? await wholeOf(this.source);
        if (this.turn !== turn) return;
        if (before) this.add(before, now);
        before = now;
        await new Promise((done) => setTimeout(done)); // the page goes on
        if (this.turn !== turn) return;
      }
      this.say(this.words());
    } catch (error) {
      if (this.turn === turn) setText(this.at.flickerText, `The flicker map cannot be shown: ${error.message}`);
    }
  }

  stop() {
    if (!this.on) return;
    this.turn = null;
    this.source?.stop();
    if (this.image) this.onForget(this.image);
    this.image = this.source = null;
    this.show();
    this.onChange();
  }

  add(before, now) {
    const { width, height } = now;
    if (!this.image) {
      this.image = new LayerImage();
      this.image.resize(width, height);
      this.image.put({ x: 0, y: 0, w: width, h: height, numbers: new Float32Array(width * height * 3) });
    }
    this.pairs++;
    addChange(this.image.numbers, before, now, this.pairs);
    this.image.touch();
    this.summarize();
    this.show();
    this.onChange();
  }

  // The mean, and the range of the colours: nearly all of it.
  summarize() {
    const { numbers } = this.image, some = [], step = Math.max(1, Math.floor(numbers.length / LOOKED_AT));
    let sum = 0, count = 0;
    for (let i = 0; i < numbers.length; i++) {
      if (!Number.isFinite(numbers[i])) continue;
      sum += numbers[i];
      count++;
      if (i % step === 0) some.push(numbers[i]);
    }
    some.sort((a, b) => a - b);
    this.mean = count ? sum / count : NaN;
    this.high = some[Math.ceil(0.995 * (some.length - 1))] || 1;
  }

  words() {
    const { pairs, total, mean } = this;
    if (pairs === 0) return "Flicker: computing";
    return `Flicker: mean change ${mean.toPrecision(4)} over ${pairs}${pairs < total ? ` of ${total}` : ""} pairs of frames`;
  }

  show() {
    const { at } = this;
    at.flicker.setAttribute("aria-pressed", String(this.on));
    setText(at.flickerText, this.on ? this.words() : "");
    if (!this.image) return;
    at.legend.hidden = false;
    ["0 steady", `${short(this.high)} or more`].forEach((text, i) => setText(at.legendEnds[i], text));
  }

  // What Picture draws instead of the layers; null when there is no map.
  look(viewport) {
    return this.image && { first: this.image, other: null, viewport, display: { ...MAP_DISPLAY, high: this.high }, compare: ALONE };
  }

  // The map's values by the picture's pixels, as PerceptualView has them.
  values() {
    if (!this.image) return null;
    return { at: (x, y) => { const v = this.image.at(x, y); return v && [(v[0] + v[1] + v[2]) / 3]; } };
  }

  describe({ x, y }) {
    const value = this.values()?.at(x, y);
    return value ? ` | flicker ${short(value[0])}` : "";
  }
}

// The frames of a sequence in the picture view: chosen, stepped through and played. What the view looks
// like (zoom, exposure, layer) is not touched. A frame is shown when all of it is there; until then the
// one before stays.
import { setText } from "../elements.js";
import { ENDED } from "../job/progress_text.js";
import { FrameStrip } from "./frame_strip.js";

const WORDS = { queued: "waiting", rendering: "tracing", encoding: "writing", finished: "done" };
const FPS = 24; // of a document that names none

export class Player {
  // `onShown()` when another frame is in sight.
  constructor(picture, elements, onShown) {
    this.onShown = onShown;
    this.picture = picture;
    this.at = elements;
    this.strip = new FrameStrip(elements.strip, (index) => this.choose(index));
    this.frames = []; // [{number, state, words, png}]
    this.wanted = null; // the number of the frame that is, or is to be, in sight; null: what the feed shows
    this.playing = false;
    picture.onFrameWhole = () => this.settle();
    picture.frameBefore = () => this.beside(-1);
    picture.shortcuts.add(this.keys());
    const on = (name, run) => elements[name].addEventListener("click", run);
    on("play", () => this.play(!this.playing));
    on("previous", () => this.step(-1));
    on("next", () => this.step(1));
    on("forming", () => this.leave());
    on("flicker", () => this.showFlicker());
    elements.slider.addEventListener("input", () => this.choose(Number(elements.slider.value)));
    this.close();
  }

  keys() {
    return [
      { keys: ["k"], name: "play or stop a sequence", run: () => this.play(!this.playing) },
      { keys: ["<"], run: () => this.step(-1) },
      { keys: [">"], shown: ["<", ">"], name: "previous frame, next frame", run: () => this.step(1) },
      { keys: ["z"], name: "flicker map of a sequence: the mean change of each pixel between frames", run: () => this.showFlicker() },
      { keys: ["Home"], run: () => this.stepTo(this.done[0]) },
      { keys: ["End"], shown: ["Home", "End"], name: "first frame, last frame", run: () => this.stepTo(this.done.at(-1)) },
    ];
  }

  get isSequence() { return this.frames.length > 1; }
  get done() { return this.frames.filter(({ state }) => state === "finished").map(({ number }) => number); }
  // The frame in sight. A feed that has ended shows the first.
  get number() { return this.picture.frame ?? (this.ended ? this.done[0] ?? null : null); }

  close() {
    this.play(false);
    this.wanted = null;
    this.frames = [];
    this.problem = "";
    this.strip.clear();
    this.at.bar.hidden = this.at.strip.hidden = true;
    this.picture.setSequence(false);
  }

  // All that the server says of the job.
  show(job) {
    this.ended = ENDED.has(job.state);
    this.fps = job.document?.fps ?? FPS;
    this.frames = (job.frames ?? []).map(({ number, state, png }) =>
      ({ number, state, png, words: this.ended && state !== "finished" ? "not done" : WORDS[state] }));
    this.at.bar.hidden = this.at.strip.hidden = !this.isSequence;
    this.picture.setSequence(this.isSequence);
    if (this.isSequence) this.write();
  }

  write() {
    const { at, frames, number } = this, index = frames.findIndex((frame) => frame.number === (this.wanted ?? number));
    this.strip.show(frames, index);
    at.slider.max = String(frames.length - 1);
    at.slider.value = String(Math.max(0, index));
    at.slider.setAttribute("aria-valuetext", index < 0 ? "the frame that forms" : `frame ${frames[index].number}, ${frames[index].words}`);
    at.play.textContent = this.playing ? "Stop" : "Play";
    at.play.setAttribute("aria-pressed", String(this.playing));
    at.play.disabled = at.previous.disabled = at.next.disabled = this.done.length === 0;
    at.forming.hidden = this.ended || this.wanted === null;
    setText(at.text, this.problem || this.words(number));
  }

  words(number) {
    const { length } = this.done, of = `${length} done, ${this.fps} frames per second`;
    if (this.wanted !== null && this.wanted !== number) return `Frame ${this.wanted} is coming; ${of}`;
    return number === null ? `The frame that forms; ${of}` : `Frame ${number}; ${of}`;
  }

  // The number of the done frame before (-1) or after (1) the one in sight; null at the ends.
  beside(by) {
    const { done } = this, now = this.wanted ?? this.number;
    if (now === null) return (by > 0 ? done[0] : done.at(-1)) ?? null;
    return (by > 0 ? done.find((number) => number > now) : done.findLast((number) => number < now)) ?? null;
  }

  choose(index) {
    const { number, state, words } = this.frames[index];
    this.play(false);
    this.problem = state === "finished" ? "" : `Frame ${number} is not there: ${words}.`;
    if (this.problem) { this.write(); this.picture.say(this.problem); return; }
    this.want(number);
  }

  step(by) { this.stepTo(this.beside(by)); }

  stepTo(number) {
    this.play(false);
    if (number === null || number === undefined) { this.picture.say(this.isSequence ? "There is no other frame." : "This job is no sequence."); return; }
    this.want(number);
    this.picture.say(`frame ${number}`);
  }

  // Back to the frame that forms.
  leave() {
    this.play(false);
    this.wanted = null;
    this.picture.showFrame(null);
    this.onShown();
    this.write();
    this.at.slider.focus();
  }

  want(number) {
    this.problem = "";
    this.wanted = number;
    this.settle();
  }

  // The frame, the one before, then those that follow, round and round.
  *order(number) {
    const { done } = this, at = done.indexOf(number), { length } = done;
    if (at < 0) return;
    yield number;
    if (at > 0) yield done[at - 1];
    for (let i = 1; i < length - (at > 0 ? 1 : 0); i++) yield done[(at + i) % length];
  }

  // The map of all frames that are done, or the picture again.
  showFlicker() {
    const { flicker, source } = this.picture;
    if (flicker.on) { flicker.stop(); return; }
    this.play(false);
    if (this.done.length < 2) { this.picture.say("There are no two frames yet."); return; }
    flicker.start(source.layer, this.done);
  }

  // Shows what is wanted if it is there.
  settle() {
    if (this.wanted === null || !this.isSequence) return;
    const { frames, source: { layer } } = this.picture, source = frames.get(layer, this.wanted);
    frames.want(layer, this.order(this.wanted));
    if (source.fault) {
      this.play(false);
      this.problem = `Frame ${this.wanted} cannot be shown: ${source.fault.message}`;
    } else if (source.whole && this.picture.frame !== this.wanted) {
      this.picture.showFrame(this.wanted);
      this.onShown();
    }
    this.write();
  }

  play(on) {
    if (on && this.done.length < 2) { this.picture.say("There are no two frames yet."); return; }
    if (on === this.playing) return;
    this.playing = on;
    if (on) {
      this.picture.flicker.stop();
      this.due = performance.now();
      this.picture.say("playing");
      requestAnimationFrame((now) => this.tick(now));
    }
    if (this.isSequence) this.write();
  }

  // A frame when it is due, none left out: where they come slower, so does the play.
  tick(now) {
    if (!this.playing) return;
    requestAnimationFrame((next) => this.tick(next));
    if (now < this.due || (this.wanted !== null && this.picture.frame !== this.wanted)) return;
    const period = 1000 / this.fps;
    this.due = this.due + 2 * period < now ? now + period : this.due + period;
    this.want(this.beside(1) ?? this.done[0]);
  }
}

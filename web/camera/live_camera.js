// A live job's camera and moved objects in the page: what they are, where they go, and the moves on their way to the
// server. One move is under way at a time; of those that come meanwhile the newest goes next, when
// something of the one before was seen.
import { moveCamera } from "../api.js";
import { cameraOf, rounded } from "./orbit.js";

const PATIENCE_MS = 250; // for the first pixels of a move, before the next is sent

export class LiveCamera {
  // `onChange()` when camera, lens, number or problem are others.
  constructor(onChange) { this.onChange = onChange; this.close(); }

  close() {
    this.id = this.camera = this.lens = this.waiting = null;
    this.moves = [];
    this.problem = "";
    this.number = this.seen = this.before = 0; // the newest view that the server has told of; that was drawn; that was left last
    this.busy = false;
    this.firstPixels = []; // ms from the last moves to their first pixels
    this.token = {};
  }

  // Takes what GET says of the job, unless moves are on their way. `distance`: of the target of a
  // camera that has none.
  take(id, { document, plan, view }, distance) {
    if (this.id !== id) { this.close(); this.id = id; }
    if (this.waiting || this.busy || (view?.number ?? 0) < this.number) return;
    const camera = document.scene.camera;
    this.number = view?.number ?? 0;
    this.lens = document.lens;
    this.moves = document.scene.moves;
    this.camera = camera?.eye ? camera : plan?.camera?.type === "perspective" ? cameraOf(plan.camera, distance) : null;
    this.onChange();
  }

  // A move is under way that will end what is seen of that view.
  awaits(view) { return Boolean(this.busy) && view <= this.before; }

  get settled() { return !this.busy && !this.waiting; }

  // A change {camera, lens, moves}, of which some may be absent; `at`: the time of the input, in performance's ms.
  move({ camera, lens, moves }, at = performance.now()) {
    if (camera) this.camera = camera;
    if (lens !== undefined) this.lens = lens;
    if (moves) this.moves = moves;
    this.waiting = { moves: moves ?? this.waiting?.moves, at: this.waiting?.at ?? at, camera: camera ? rounded(camera) : this.waiting?.camera, lens: lens === undefined ? this.waiting?.lens : lens };
    this.pump();
    this.onChange();
  }

  async pump() {
    if (this.busy || !this.waiting) return;
    const { token } = this, { at, ...change } = this.waiting;
    this.busy = true;
    this.before = this.number;
    this.waiting = null;
    try {
      const answer = await moveCamera(this.id, change);
      if (token !== this.token) return;
      this.number = answer.view.number;
      if (!this.waiting) { this.camera = answer.camera?.eye ? answer.camera : this.camera; this.lens = answer.lens; this.moves = answer.moves; }
      this.problem = "";
      await this.untilSeen(answer.view.number, at);
    } catch (error) {
      if (token === this.token) this.problem = `${error.pointer ? `${error.pointer}: ` : ""}${error.message}`;
    } finally {
      if (token === this.token) {
        this.busy = false;
        this.onChange();
        this.pump();
      }
    }
  }

  untilSeen(number, at) {
    return new Promise((done) => {
      const end = () => { clearTimeout(timer); this.look = null; done(); };
      const timer = setTimeout(end, PATIENCE_MS);
      this.look = () => {
        if (this.seen < number) return;
        this.firstPixels.push(this.seenAt - at);
        if (this.firstPixels.length > 64) this.firstPixels.shift();
        end();
      };
      this.look();
    });
  }

  // Pixels of a view have been given to the browser to show.
  drawn(number) {
    if (number <= this.seen) return;
    this.seen = number;
    this.seenAt = performance.now();
    this.look?.();
  }
}

// Looks at a resource again and again while the page is seen: soon after it has changed, ever more
// seldom while it stays the same, and ever more seldom while the server cannot be reached.
import { getChanged } from "./api.js";

const LONGEST_AFTER_ERRORS_MS = 30000;
const SLOWER = 1.5;

export class Poll {
  // onBody(body) when it has changed; onState("live" or "lost", error) after each look.
  constructor(onBody, onState, { quickMs = 1000, slowMs = 8000 } = {}) {
    Object.assign(this, { onBody, onState, quickMs, slowMs, path: null });
    document.addEventListener("visibilitychange", () => { if (!document.hidden && this.path) this.look(); });
  }

  // Another address: what is known of the one before is forgotten. null: stop.
  follow(path) {
    clearTimeout(this.timer);
    this.path = path;
    this.tag = null;
    this.wait = this.quickMs;
    this.errors = 0;
    return path ? this.look() : Promise.resolve();
  }

  async look() {
    clearTimeout(this.timer);
    const { path } = this;
    const turn = this.turn = {}; // an answer to an earlier question comes too late
    let state = "live", failure, answer = null;
    try {
      answer = await getChanged(path, this.tag);
    } catch (error) {
      state = "lost";
      failure = error;
    }
    if (this.turn !== turn || this.path !== path) return;
    this.errors = state === "lost" ? this.errors + 1 : 0;
    this.wait = answer ? this.quickMs : Math.min(this.wait * SLOWER, this.slowMs);
    if (answer) this.tag = answer.tag;
    this.onState(state, failure);
    if (answer) this.onBody(answer.body);
    if (document.hidden || this.path !== path || this.turn !== turn) return;
    const pause = this.errors ? Math.min(this.quickMs * 2 ** this.errors, LONGEST_AFTER_ERRORS_MS) : this.wait;
    this.timer = setTimeout(() => this.look(), pause);
  }
}

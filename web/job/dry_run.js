// Asks the server what it thinks of a document, a little after its last change.
import { planJob } from "../api.js";

const AFTER_MS = 350;
const AGAIN_MS = 3000; // when the server was away or busy

export class DryRun {
  // onAnswer({plan}, {fault: {pointer, text}} or {trouble}) for the latest document alone.
  constructor(onAnswer) { this.onAnswer = onAnswer; }

  check(document, wait = AFTER_MS) {
    this.stop();
    this.timer = setTimeout(() => this.ask(structuredClone(document)), wait);
  }

  stop() {
    clearTimeout(this.timer);
    this.control?.abort();
  }

  async ask(document) {
    const control = this.control = new AbortController();
    let answer;
    try {
      answer = await planJob(document, control.signal);
    } catch (error) {
      if (control.signal.aborted) return;
      const refused = error.status >= 400 && error.status < 500;
      answer = refused ? { fault: { pointer: error.pointer ?? "", text: error.message } } : { trouble: error.message };
      if (!refused) this.check(document, AGAIN_MS);
    }
    if (!control.signal.aborted || answer.trouble) this.onAnswer(answer);
  }
}

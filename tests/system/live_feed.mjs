// A reader of a live job's pixel feed, and what it hears, with the time of each message.
import http from "node:http";

const slower = Number(process.env.TEST_SLOWER ?? 1); // of builds with sanitizers (tests/run)

// {kind: "view" | "size" | "block", view, x, y, w, h, ms, bytes}; `view` is the one in whose part of
// the feed the message came.
export class LiveFeed {
  constructor(url, id, layer = "beauty") {
    this.heard = [];
    this.waiting = new Set();
    this.view = 0;
    this.rest = Buffer.alloc(0);
    this.open = new Promise((done, fail) => {
      this.request = http.get(`${url}/v1/jobs/${id}/pixels?layer=${layer}`, (answer) => {
        if (answer.statusCode !== 200) { fail(new Error(`the feed answered ${answer.statusCode}`)); return; }
        answer.socket.setNoDelay(true);
        answer.on("data", (bytes) => this.take(bytes));
        answer.on("end", () => this.hear({ kind: "end" }));
        answer.on("error", () => {});
        done();
      });
      this.request.on("error", fail);
    });
  }

  take(bytes) {
    this.rest = this.rest.length > 0 ? Buffer.concat([this.rest, bytes]) : bytes;
    while (this.rest.length >= 32) {
      const [x, y, w, h] = [8, 12, 16, 20].map((at) => this.rest.readUInt32LE(at));
      if (this.rest.readUInt32LE(0) !== 0x58505753) throw new Error("no feed");
      const size = 32 + w * h * 6;
      if (this.rest.length < size) return;
      if (w === 0 && h > 0) this.view = h;
      this.hear({ kind: w > 0 ? "block" : h > 0 ? "view" : "size", x, y, w, h, bytes: Buffer.from(this.rest.subarray(32, size)) });
      this.rest = this.rest.subarray(size);
    }
  }

  hear(message) {
    const heard = { ...message, view: this.view, ms: performance.now() };
    this.heard.push(heard);
    for (const wait of this.waiting) if (wait.when(heard)) { this.waiting.delete(wait); wait.done(heard); }
  }

  // The first message, from now on, of which `when` is true.
  next(when, seconds = 30 * slower) {
    return new Promise((done, fail) => {
      const wait = { when, done: (heard) => { clearTimeout(timer); done(heard); } };
      const timer = setTimeout(() => { this.waiting.delete(wait); fail(new Error(`not heard within ${seconds} s`)); }, seconds * 1000);
      this.waiting.add(wait);
    });
  }

  close() { this.request.destroy(); }
}

const agent = new http.Agent({ keepAlive: true, maxSockets: 4 });

// {status, body, ms}: parsed, when it was there.
export function ask(method, url, body) {
  const text = body === undefined ? undefined : typeof body === "string" ? body : JSON.stringify(body);
  return new Promise((done, fail) => {
    const request = http.request(url, { method, agent, headers: text === undefined ? {} : { "Content-Type": "application/json", "Content-Length": Buffer.byteLength(text) } }, (answer) => {
      const parts = [];
      answer.on("data", (part) => parts.push(part));
      answer.on("end", () => {
        const bytes = Buffer.concat(parts);
        let parsed = null;
        try { parsed = JSON.parse(bytes.toString()); } catch { /* a picture, or nothing */ }
        done({ status: answer.statusCode, type: answer.headers["content-type"], etag: answer.headers.etag, body: parsed, bytes, ms: performance.now() });
      });
    });
    request.setNoDelay(true);
    request.on("error", fail);
    request.end(text);
  });
}

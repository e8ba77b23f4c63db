// A tev that only listens: takes its documented packets apart, strictly, and keeps the images.
//   u32 length of all, u8 kind, payload; little-endian; texts end with a zero byte.
//   create (4):    u8 grab focus, name, i32 width, height, count, channel names
//   update v3 (6): u8 grab focus, name, i32 count, channel names, i32 x, y, width, height,
//                  i64 offsets, i64 strides (numbers, a channel each), f32 numbers
import { createServer } from "node:net";

class Reader {
  constructor(bytes) { this.bytes = bytes; this.at = 5; }
  skip(n) { if ((this.at += n) > this.bytes.length) throw new Error("a packet is too short"); return this.at - n; }
  u8() { return this.bytes.readUInt8(this.skip(1)); }
  i32() { return this.bytes.readInt32LE(this.skip(4)); }
  i64() { return Number(this.bytes.readBigInt64LE(this.skip(8))); }
  text() {
    const end = this.bytes.indexOf(0, this.at);
    if (end < 0) throw new Error("a text has no end");
    const text = this.bytes.toString("utf8", this.at, end);
    this.at = end + 1;
    return text;
  }
  list(n, read) { return Array.from({ length: n }, () => this[read]()); }
  rest() { return this.bytes.subarray(this.at); }
}

export class FakeTev {
  constructor() { Object.assign(this, { images: new Map(), created: 0, updates: 0, faults: [], sockets: new Set() }); }

  // Resolves with the port. `delay`: milliseconds before each chunk is taken.
  listen(port = 0, delay = 0) {
    this.server = createServer((socket) => {
      let held = Buffer.alloc(0);
      this.sockets.add(socket);
      socket.on("error", () => {});
      socket.on("close", () => this.sockets.delete(socket));
      socket.on("data", (chunk) => {
        held = Buffer.concat([held, chunk]);
        while (held.length >= 5 && held.length >= held.readUInt32LE(0)) {
          const length = held.readUInt32LE(0), packet = held.subarray(0, length);
          try { this.take(packet); } catch (error) { this.faults.push(error.message); }
          held = held.subarray(Math.max(5, length));
        }
        if (delay) { socket.pause(); setTimeout(() => socket.resume(), delay); }
      });
    });
    return new Promise((done) => this.server.listen(port, "127.0.0.1", () => done(this.server.address().port)));
  }

  close() { for (const socket of this.sockets) socket.destroy(); return new Promise((done) => this.server.close(done)); }

  take(packet) {
    const kind = packet.readUInt8(4), r = new Reader(packet), focus = r.u8(), name = r.text();
    if (focus > 1) throw new Error(`${focus} is no flag`);
    if (kind === 4) this.create(r, name);
    else if (kind === 6) this.update(r, name);
    else throw new Error(`kind ${kind} is not expected`);
  }

  create(r, name) {
    const [width, height, count] = r.list(3, "i32"), names = r.list(count, "text");
    if (r.rest().length) throw new Error("a create packet is too long");
    this.created++;
    this.images.set(name, { width, height, channels: new Map(names.map((channel) => [channel, new Float32Array(width * height).fill(-1)])) });
  }

  update(r, name) {
    const image = this.images.get(name), count = r.i32(), names = r.list(count, "text");
    const [x, y, w, h] = r.list(4, "i32"), offsets = r.list(count, "i64"), strides = r.list(count, "i64"), rest = r.rest();
    if (!image) throw new Error(`an update of ${name}, which was not created`);
    if (x < 0 || y < 0 || w < 1 || h < 1 || x + w > image.width || y + h > image.height) throw new Error(`${x} ${y} ${w} ${h} is not inside`);
    const numbers = Math.max(...offsets.map((offset, c) => offset + (w * h - 1) * strides[c] + 1));
    if (rest.length !== 4 * numbers) throw new Error(`${rest.length} bytes for ${numbers} numbers`);
    names.forEach((channel, c) => {
      const out = image.channels.get(channel);
      if (!out) throw new Error(`a channel ${channel} that was not created`);
      for (let i = 0; i < w * h; i++) out[(y + Math.floor(i / w)) * image.width + x + i % w] = rest.readFloatLE(4 * (offsets[c] + i * strides[c]));
    });
    this.updates++;
  }
}

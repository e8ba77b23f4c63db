// The live pixel feed: a chunked response of binary blocks (PROTOCOL.md, "Pixel feed").
//
//   u32 magic "SWPX", u16 version, u16 format (three numbers a pixel: 1 half floats, 2 floats; 3 and
//   4 the same, and then one more a pixel, its alpha), u32 x, y, w, h, u64 revision, then w*h*3
//   numbers, row by row, and of formats 3 and 4 w*h alphas. w = h = 0 tells the image's size
//   in x and y. Who has read a message has every change up to its revision.

const HEADER_BYTES = 32;
const MAGIC = 0x58505753;
const MAX_SIDE = 16384;
const MAX_BLOCK_PIXELS = 1 << 22;
const NUMBERS = { 1: Uint16Array, 2: Float32Array, 3: Uint16Array, 4: Float32Array };
const CHANNELS = { 1: 3, 2: 3, 3: 4, 4: 4 };

// Cuts a byte stream into blocks. Keeps at most one unfinished block.
export class BlockParser {
  constructor() { this.parts = []; this.size = 0; this.need = HEADER_BYTES; this.header = null; }

  // Yields {x, y, w, h, revision, numbers, alpha} (null: opaque) for every block that is now whole.
  *feed(chunk) {
    this.parts.push(chunk);
    this.size += chunk.byteLength;
    while (this.size >= this.need) {
      const bytes = this.take(this.need);
      if (!this.header) {
        this.header = readHeader(bytes);
        const { w, h, channels, numbers } = this.header;
        this.need = w * h * channels * numbers.BYTES_PER_ELEMENT;
        if (this.need > 0) continue;
      }
      const { numbers, channels, ...block } = this.header;
      const all = new numbers(block.w > 0 ? bytes.buffer : 0), colors = block.w * block.h * 3;
      yield { ...block, numbers: all.subarray(0, colors), alpha: channels === 4 && block.w > 0 ? all.subarray(colors) : null };
      this.header = null;
      this.need = HEADER_BYTES;
    }
  }

  // The first n bytes in a buffer of their own, so that numbers are aligned.
  take(n) {
    const out = new Uint8Array(n);
    let at = 0;
    while (at < n) {
      const part = this.parts[0];
      const used = Math.min(part.byteLength, n - at);
      out.set(part.subarray(0, used), at);
      at += used;
      if (used === part.byteLength) this.parts.shift();
      else this.parts[0] = part.subarray(used);
    }
    this.size -= n;
    return out;
  }
}

function readHeader(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, HEADER_BYTES);
  const header = {
    x: view.getUint32(8, true), y: view.getUint32(12, true),
    w: view.getUint32(16, true), h: view.getUint32(20, true),
    revision: view.getBigUint64(24, true), numbers: NUMBERS[view.getUint16(6, true)], channels: CHANNELS[view.getUint16(6, true)],
  };
  if (view.getUint32(0, true) !== MAGIC || view.getUint16(4, true) !== 1 || !header.numbers)
    throw new Error("the pixel feed has another format: reload the page");
  if (header.x > MAX_SIDE || header.y > MAX_SIDE || header.w * header.h > MAX_BLOCK_PIXELS)
    throw new Error("the pixel feed names a block that is too large");
  return header;
}

// Reads a feed until its end; after a break goes on from the revision that it had. `urlAfter` makes
// the address from a revision (a BigInt, or null for none, as at first), `onBlock` gets blocks,
// `onState` "live", "lost", "ended" or "refused": there is no such feed. Returns a function that stops it.
export function followPixels(urlAfter, revision, onBlock, onState) {
  const control = new AbortController();
  run();
  return () => control.abort();

  async function run() {
    for (let wait = 250; !control.signal.aborted; wait = Math.min(wait * 2, 5000)) {
      try {
        const response = await fetch(urlAfter(revision), { signal: control.signal, cache: "no-store" });
        // 401: the page asks for a token when its next question is refused, and begins anew with it.
        if ([401, 403, 404, 409].includes(response.status)) {
          const problem = await response.json().catch(() => null);
          if (!control.signal.aborted) onState("refused", new Error(problem?.detail ?? problem?.title ?? `the server answered ${response.status}`));
          return;
        }
        if (!response.ok) throw new Error(`the pixel feed answered ${response.status}`);
        onState("live");
        wait = 250;
        await readAll(response.body.getReader());
        onState("ended");
        return;
      } catch (error) {
        if (control.signal.aborted) return;
        onState("lost", error);
        await new Promise((resolve) => setTimeout(resolve, wait));
      }
    }
  }

  async function readAll(reader) {
    const parser = new BlockParser();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      for (const block of parser.feed(value)) {
        if (control.signal.aborted) return;
        onBlock(block);
        revision = block.revision;
      }
    }
  }
}

// One layer's numbers as they are, beside the GPU: for the probe, the histogram and the figures, and
// to fill a texture again. Three numbers a pixel, half floats or floats. Does not grow with updates:
// what has changed is a set of blocks. Alpha lies beside, where a block has brought some; else it is
// null and everything covers its pixels, as in coarse pictures.
import { CoarsePicture } from "./coarse_picture.js";
import { halfTable } from "./half.js";

export const BLOCK_PX = 64;

const ONE = { Uint16Array: 0x3c00, Float32Array: 1 };

const MOST_LOOKED_AT = 300000;

// The step over {x0, y0, x1, y1} along both axes with which about 300,000 pixels at most are met.
export const sparseStep = ({ x0, y0, x1, y1 }) => Math.max(1, Math.ceil(Math.sqrt((x1 - x0) * (y1 - y0) / MOST_LOOKED_AT)));

export class LayerImage {
  // `view`: of a live job the number of the camera's view that is in sight; 0 for none. `coarseShown`:
  // the coarse picture that fills all of this one; null for none. `detail`: pixels along each axis that
  // one of what is in sight stands for.
  constructor() { this.width = this.height = 0; this.version = 0; this.changed = new Set(); this.view = 0; this.coarseShown = null; }

  get detail() { return this.coarseShown ? this.width / this.coarseShown.width : 1; }

  // A picture of that size in which nothing is there yet; keeps the one that is there when the size
  // is the same.
  resize(width, height) {
    if (width === this.width && height === this.height) return false;
    this.width = width;
    this.height = height;
    this.columns = Math.ceil(width / BLOCK_PX);
    this.rows = Math.ceil(height / BLOCK_PX);
    this.seen = new Uint8Array(this.columns * this.rows);
    this.numbers = this.alpha = this.coarseShown = null;
    this.touch();
    return true;
  }

  // Until its own blocks come, that picture's are shown; they are not there for anything else.
  showOver(old) {
    if (!old.numbers || this.numbers) return;
    this.resize(old.width, old.height);
    this.numbers = old.numbers.slice();
    this.alpha = old.alpha?.slice() ?? null;
    this.touch();
  }

  // All blocks are its own.
  isWhole() { return this.numbers !== null && !this.seen.includes(0); }

  // All blocks are to be shown again.
  touch() {
    for (let i = 0; i < this.columns * this.rows; i++) this.changed.add(i);
    this.version++;
  }

  // A view of a live job begins. The one before stays in sight until there is something of it.
  beginView(number, width, height) {
    if (this.next?.number === number) return;
    this.next = { number, width, height };
    this.coarse = null;
  }

  // The size of the picture whose blocks come now: of a view maybe a coarse one.
  beginPicture(width, height) {
    const full = this.next ?? { width, height };
    this.resize(full.width, full.height);
    if (width === full.width && height === full.height) this.coarse = null;
    else if (this.coarse?.width !== width || this.coarse.height !== height) this.coarse = new CoarsePicture(width, height);
  }

  showCoarse(kind) {
    if (this.numbers?.constructor !== kind) this.numbers = new kind(this.width * this.height * 3);
    this.coarse.stretch(this.numbers, this.width, this.height);
    this.alpha = null;
    this.view = this.next.number;
    this.coarseShown = this.coarse;
    this.seen.fill(1);
    this.touch();
  }

  // Nothing of another view stays beside blocks of this one.
  clearView() {
    this.view = this.next.number;
    this.seen.fill(0);
    this.numbers?.fill(0);
    this.alpha = null;
    this.touch();
  }

  // A block of the pixel feed, or of a file. Blocks outside the picture are ignored.
  put({ x, y, w, h, numbers, alpha = null }) {
    if (w === 0) {
      if (h > 0) this.beginView(h, x, y);
      else this.beginPicture(x, y);
      return;
    }
    if (this.coarse) {
      if (this.coarse.put({ x, y, w, h, numbers })) this.showCoarse(numbers.constructor);
      return;
    }
    if (this.next && this.view !== this.next.number) this.clearView();
    if (x + w > this.width || y + h > this.height) return;
    if (this.coarseShown) { this.coarseShown = null; this.touch(); }
    const kind = numbers.constructor;
    if (this.numbers?.constructor !== kind) {
      this.numbers = new kind(this.width * this.height * 3);
      this.alpha = null;
    }
    if (alpha) this.alpha ??= new kind(this.width * this.height).fill(ONE[kind.name]);
    for (let row = 0; row < h && this.alpha; row++) {
      const at = (y + row) * this.width + x;
      if (alpha) this.alpha.set(alpha.subarray(row * w, (row + 1) * w), at);
      else this.alpha.fill(ONE[kind.name], at, at + w);
    }
    for (let row = 0; row < h; row++)
      this.numbers.set(numbers.subarray(row * w * 3, (row + 1) * w * 3), ((y + row) * this.width + x) * 3);
    for (let j = Math.floor(y / BLOCK_PX); j * BLOCK_PX < y + h; j++)
      for (let i = Math.floor(x / BLOCK_PX); i * BLOCK_PX < x + w; i++) {
        this.changed.add(j * this.columns + i);
        this.seen[j * this.columns + i] = 1;
      }
    this.version++;
  }

  isFloat() { return this.numbers instanceof Float32Array; }

  // The block of that index as {x, y, w, h}.
  block(index) {
    const x = index % this.columns * BLOCK_PX, y = Math.floor(index / this.columns) * BLOCK_PX;
    return { x, y, w: Math.min(BLOCK_PX, this.width - x), h: Math.min(BLOCK_PX, this.height - y) };
  }

  has(x, y) {
    return x >= 0 && y >= 0 && x < this.width && y < this.height && this.numbers !== null &&
      this.seen[Math.floor(y / BLOCK_PX) * this.columns + Math.floor(x / BLOCK_PX)] === 1;
  }

  // A function from an index into `numbers` to the value there.
  reader() {
    const { numbers } = this, table = halfTable();
    return this.isFloat() ? (i) => numbers[i] : (i) => table[numbers[i]];
  }

  // The pixel's three values, null where there is none yet.
  at(x, y) {
    if (!this.has(x, y)) return null;
    const i = (y * this.width + x) * 3, value = this.reader();
    return [value(i), value(i + 1), value(i + 2)];
  }

  // The pixel's alpha; null where nothing says what it is.
  alphaAt(x, y) {
    if (!this.alpha || !this.has(x, y)) return null;
    const v = this.alpha[y * this.width + x];
    return this.isFloat() ? v : halfTable()[v];
  }

  // Calls visit(r, g, b, x, y) for the pixels that are there in {x0, y0, x1, y1}, every `step`-th
  // along both axes.
  each({ x0, y0, x1, y1 }, step, visit) {
    if (!this.numbers) return;
    const { width } = this, value = this.reader();
    for (let y = y0; y < y1; y += step) {
      const blocks = Math.floor(y / BLOCK_PX) * this.columns;
      for (let x = x0; x < x1; x += step) {
        if (!this.seen[blocks + (x >> 6)]) continue;
        const i = (y * width + x) * 3;
        visit(value(i), value(i + 1), value(i + 2), x, y);
      }
    }
  }
}

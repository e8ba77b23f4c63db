// A coarse picture of a live job's view while it comes: shown when it is whole, so that nothing of the
// view before is seen beside it.

export class CoarsePicture {
  constructor(width, height) { this.width = width; this.height = height; this.missing = width * height; this.numbers = null; }

  // Takes a block; true when the picture is whole now. No pixel comes twice before.
  put({ x, y, w, h, numbers }) {
    if (x + w > this.width || y + h > this.height) return false;
    this.numbers ??= new numbers.constructor(this.width * this.height * 3);
    for (let row = 0; row < h; row++)
      this.numbers.set(numbers.subarray(row * w * 3, (row + 1) * w * 3), ((y + row) * this.width + x) * 3);
    this.missing -= w * h;
    return this.missing <= 0;
  }

  // Over all of `out`, a picture of that size: each of its pixels as the coarse one below its middle.
  stretch(out, width, height) {
    const columns = Int32Array.from({ length: width }, (_, x) => 3 * Math.floor((x + 0.5) * this.width / width));
    let above = -1;
    for (let y = 0; y < height; y++) {
      const row = Math.floor((y + 0.5) * this.height / height), start = 3 * y * width;
      if (row === above) { out.copyWithin(start, start - 3 * width, start); continue; }
      const from = this.numbers.subarray(3 * row * this.width, 3 * (row + 1) * this.width);
      for (let x = 0, at = start; x < width; x++) {
        const i = columns[x];
        out[at++] = from[i]; out[at++] = from[i + 1]; out[at++] = from[i + 2];
      }
      above = row;
    }
  }
}

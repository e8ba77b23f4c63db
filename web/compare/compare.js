// Two layers side by side: a wipe at any angle, one or the other, their difference, their mean; and the figures
// over what is in sight, as `shearwater compare` has them.

const ID = /^[0-9a-z]{26}$/;
const GRAB = 12; // pixels of the canvas from the line at which it can be taken

export class Compare {
  constructor(onChange) {
    this.onChange = onChange;
    this.counted = {}; // what the figures were last counted of, and they
    this.mode = "off"; // off, wipe, toggle, difference, onion, ssim, flip
    this.flipped = false; // of toggle: the other is shown
    this.position = 0.5; // of the line, as a share of the way across the canvas
    this.angle = 0; // degrees; 0: upright
  }

  // What the shader shows.
  get shown() {
    if (this.mode === "toggle") return this.flipped ? "other" : "off";
    return this.metric ? "off" : this.mode;
  }

  // Whose map is shown instead: "ssim", "flip" or "".
  get metric() { return this.mode === "ssim" || this.mode === "flip" ? this.mode : ""; }

  set(changes) {
    Object.assign(this, changes);
    if (this.mode === "off") this.counted = {};
    this.position = Math.min(1, Math.max(0, this.position));
    this.angle = ((this.angle + 90) % 180 + 180) % 180 - 90;
    this.onChange();
  }

  // The figures, counted anew only when the pixels or what is in sight have changed.
  figures(first, other, area, step) {
    const of = [first.version, other.version, step, ...Object.values(area)].join();
    if (this.counted.first !== first || this.counted.other !== other || this.counted.of !== of)
      this.counted = { first, other, of, found: figures(first, other, area, step) };
    return this.counted.found;
  }

  // The wipe's line on a canvas of that size: x * [0] + y * [1] > [2] is the other's side.
  line(width, height) {
    const a = this.angle * Math.PI / 180, nx = Math.cos(a), ny = Math.sin(a);
    const reach = (Math.abs(nx) * width + Math.abs(ny) * height) / 2;
    return [nx, ny, (nx * width + ny * height) / 2 + (2 * this.position - 1) * reach];
  }

  // Takes a drag that begins on the line.
  drag(kind, x, y, width, height, ratio) {
    if (this.mode !== "wipe") return false;
    const [nx, ny, at] = this.line(width, height);
    const away = nx * x + ny * y - at;
    if (kind === "down") return Math.abs(away) <= GRAB * ratio;
    const reach = (Math.abs(nx) * width + Math.abs(ny) * height) / 2;
    this.set({ position: this.position + away / reach / 2 });
    return true;
  }
}

// Which side of the wipe is which; which of two is shown: [{x, y, text}] on the canvas of a picture view.
export function sideNames({ source, other, compare, ratio, job: shown, viewport }) {
  const { width, height } = viewport.canvas;
  if (!other || compare.mode === "off") return [];
  const isFrame = source.frame !== other.frame;
  const name = ({ job, layer, frame }) => `${layer.replaceAll("_", " ")}${job === shown ? "" : ` of ${ID.test(job) ? job.slice(-6) : job}`}${isFrame && frame !== null && frame !== undefined ? ` of frame ${frame}` : ""}`;
  const y = 16 * ratio, both = `${name(source)}, ${name(other)}`;
  const texts = { ssim: `SSIM: ${both}`, flip: `FLIP: ${both}`, difference: `${name(source)} − ${name(other)}`, onion: `${name(source)} + ${name(other)}`, toggle: name(compare.flipped ? other : source) };
  if (compare.mode !== "wipe") return [{ x: width / 2, y, text: texts[compare.mode] }];
  const [nx, ny, at] = compare.line(width, height), inside = (v, most, edge) => Math.min(most - edge, Math.max(edge, v));
  const upright = Math.abs(nx) > 0.5, x = upright ? (at - ny * y) / nx : width / 2, away = upright ? 70 * ratio : 0;
  const place = (side) => ({ x: inside(x + side * away, width, 70 * ratio),
                             y: upright ? y : inside(at / ny - nx * x / ny + side * Math.sign(ny) * 24 * ratio, height, y) });
  return [{ ...place(-1), text: name(source) }, { ...place(1), text: name(other) }];
}

// The difference of two images, for a walk over pixels as LayerImage.each makes it.
export function differenceOf(first, other) {
  const { width, height } = first;
  return { width, height, numbers: first.numbers && other.numbers, each(area, step, visit) {
    const value = other.reader();
    first.each(area, step, (r, g, b, x, y) => {
      if (!other.has(x, y)) return;
      const i = (y * other.width + x) * 3;
      visit(r - value(i), g - value(i + 1), b - value(i + 2), x, y);
    });
  } };
}

// rmse and relmse of `test` against `reference` over every `step`-th pixel of {x0, y0, x1, y1}: relmse is the mean of
// (t - r)^2 / (r^2 + 0.01 mean(r)^2). Null where the two have nothing in common. Pixels that are not
// finite are counted and left out.
export function figures(reference, test, area, step = 1) {
  if (reference.width !== test.width || reference.height !== test.height) return null;
  if (!reference.numbers || !test.numbers) return null;
  const own = reference.reader(), other = test.reader();
  let sum = 0, count = 0, bad = 0, squares = 0, relative = 0;
  const each = (visit) => {
    for (let y = area.y0; y < area.y1; y += step)
      for (let x = area.x0; x < area.x1; x += step)
        if (reference.has(x, y) && test.has(x, y)) visit((y * reference.width + x) * 3);
  };
  const finite = (i) => Number.isFinite(own(i) + own(i + 1) + own(i + 2) + other(i) + other(i + 1) + other(i + 2));
  each((i) => {
    if (!finite(i)) { bad++; return; }
    sum += own(i) + own(i + 1) + own(i + 2);
    count += 3;
  });
  if (count === 0) return null;
  const floor = 0.01 * (sum / count) ** 2;
  each((i) => {
    if (!finite(i)) return;
    for (let c = i; c < i + 3; c++) {
      const square = (other(c) - own(c)) ** 2, weight = own(c) ** 2 + floor;
      squares += square;
      relative += weight > 0 ? square / weight : square;
    }
  });
  return { rmse: Math.sqrt(squares / count), relmse: relative / count, pixels: count / 3, bad };
}

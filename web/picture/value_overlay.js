// The pixels' own values written on them, once they are large enough, and marks of probes.

const LEGIBLE = 56; // pixels of the canvas a pixel, at a pixel ratio of one
const DIGITS = 4;

// A number in at most `digits` significant places.
export function short(v, digits = DIGITS) {
  if (!Number.isFinite(v)) return Number.isNaN(v) ? "NaN" : v > 0 ? "inf" : "−inf";
  const size = Math.abs(v);
  const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? v.toExponential(Math.max(0, digits - 2)) : String(Number(v.toPrecision(digits)));
  return text.replace("-", "−");
}

export class ValueOverlay {
  constructor(canvas) { this.canvas = canvas; this.context = canvas.getContext("2d"); this.written = 0; this.clear = true; }

  // `areas`: [{x, y, width, height, name}] of the picture; `names`: [{x, y, text}] on the canvas; `marks`: [{x, y, name}] of the picture's pixels; `image`: the one whose values are written;
  // `scalar`: its three values are one.
  draw({ image, viewport, areas, names, marks, scalar, ratio }) {
    const { context, canvas } = this, { zoom } = viewport, values = Boolean(image) && zoom >= LEGIBLE * ratio;
    const empty = !values && areas.length + names.length + marks.length === 0;
    if (empty && this.clear) return; // a canvas that is touched is drawn by the browser anew
    this.clear = empty;
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.written = 0;
    if (values) this.writeValues(image, viewport, scalar, ratio);
    context.font = `${12 * ratio}px system-ui, sans-serif`;
    context.textAlign = "center";
    for (const { x, y, text } of names) this.write(text, x, y, ratio);
    context.textAlign = "left";
    for (const area of areas) this.outline(area, viewport, ratio);
    for (const { x, y, name } of marks) {
      const left = (x - viewport.x) * zoom, top = (y - viewport.y) * zoom;
      const size = Math.max(zoom, 9 * ratio), inset = (zoom - size) / 2;
      for (const [color, wide] of [["#000", 3], ["#fff", 1.5]]) {
        context.strokeStyle = color;
        context.lineWidth = wide * ratio;
        context.strokeRect(left + inset, top + inset, size, size);
      }
      this.write(name, left + inset + size + 4 * ratio, top + zoom / 2, ratio);
    }
  }

  outline({ x, y, width, height, name }, viewport, ratio) {
    const { context } = this, { zoom } = viewport;
    const left = (x - viewport.x) * zoom, top = (y - viewport.y) * zoom;
    context.lineWidth = 2 * ratio;
    for (const [color, dash] of [["#000", []], ["#ffd479", [6 * ratio, 4 * ratio]]]) {
      context.strokeStyle = color;
      context.setLineDash(dash);
      context.strokeRect(left, top, width * zoom, height * zoom);
    }
    context.setLineDash([]);
    this.write(name, Math.max(left, 0) + 6 * ratio, Math.max(top, 0) + 12 * ratio, ratio);
  }

  writeValues(image, viewport, scalar, ratio) {
    const { context } = this, { zoom } = viewport, { x0, y0, x1, y1 } = viewport.visible();
    const line = Math.min(zoom / 4.5, 15 * ratio);
    context.font = `${Math.min(line, zoom / 5)}px ui-monospace, monospace`;
    context.textAlign = "center";
    for (let y = y0; y < y1; y++)
      for (let x = x0; x < x1; x++) {
        const values = image.at(x, y);
        if (!values) continue;
        const lines = scalar ? values.slice(0, 1) : values;
        const left = (x + 0.5 - viewport.x) * zoom, top = (y + 0.5 - viewport.y) * zoom;
        lines.forEach((v, i) => this.write(short(v), left, top + (i - (lines.length - 1) / 2) * line * 1.15, ratio));
        this.written++;
      }
  }

  // White with a dark edge: to be read on every colour.
  write(text, x, y, ratio) {
    const { context } = this;
    context.textBaseline = "middle";
    context.lineJoin = "round";
    context.lineWidth = 3 * ratio;
    context.strokeStyle = "#000";
    context.strokeText(text, x, y);
    context.fillStyle = "#fff";
    context.fillText(text, x, y);
  }
}

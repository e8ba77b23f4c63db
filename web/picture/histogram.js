// How the values in sight are spread: stops for a picture, the range of the colours otherwise, with the
// colours below.
import { magnitudes, signs, STEPS } from "./color_map.js";
import { sparseStep } from "./layer_image.js";

const BINS = 128;
const STOPS = [-12, 6];
const COLORS = ["#e0402c", "#2fae52", "#2f6fe8"];
const RAMP_TALL = 10;

export class Histogram {
  constructor(canvas, text) { this.canvas = canvas; this.text = text; this.context = canvas.getContext("2d"); }

  // Counts by channel: {bins: [3][BINS], below, above, bad, count}.
  count(image, area, display) {
    const stops = display.shownAs === "picture";
    const logs = stops || (display.logarithmic && display.shownAs === "colour");
    const [low, high] = stops ? STOPS : logs ? [Math.log2(display.low), Math.log2(display.high)] : display.shownAs === "vector" ? [-1, 1]
      : display.shownAs === "sign" ? [-display.high, display.high] : [display.low, display.high];
    const out = { bins: COLORS.map(() => new Uint32Array(BINS)), zero: 0, bad: 0, count: 0, low, high, stops, logs };
    image.each(area, sparseStep(area), (r, g, b) => {
      out.count++;
      if (!Number.isFinite(r + g + b)) { out.bad++; return; }
      if (stops && r <= 0 && g <= 0 && b <= 0) out.zero++;
      [r, g, b].forEach((v, c) => {
        const t = ((logs ? Math.log2(v) : v) - low) / (high - low);
        if (t >= 0 && t <= 1) out.bins[c][Math.min(BINS - 1, Math.floor(t * BINS))]++;
      });
    });
    return out;
  }

  ramp({ shownAs }) {
    return shownAs === "colour" ? this.magnitudes ??= magnitudes() : shownAs === "sign" ? this.signs ??= signs() : null;
  }

  // `name`: what is counted, to be said before its range.
  draw(image, area, display, scalar, name = "") {
    const { context, canvas } = this, { width } = canvas, ramp = this.ramp(display);
    const height = canvas.height - (ramp ? RAMP_TALL : 0);
    const { bins, zero, bad, count, low, high, stops, logs } = this.count(image, area, display);
    const used = scalar ? bins.slice(0, 1) : bins;
    // The fullest bin would flatten the rest: the square root keeps both in sight.
    const most = Math.sqrt(Math.max(1, ...used.map((b) => Math.max(...b))));
    context.clearRect(0, 0, width, canvas.height);
    context.globalCompositeOperation = "lighter";
    used.forEach((b, c) => {
      context.fillStyle = scalar ? "#a9b4c0" : COLORS[c];
      b.forEach((n, i) => {
        const tall = Math.sqrt(n) / most * height;
        context.fillRect(i * width / BINS, height - tall, width / BINS, tall);
      });
    });
    context.globalCompositeOperation = "source-over";
    if (ramp)
      for (let i = 0; i < STEPS; i++) {
        context.fillStyle = `rgb(${ramp[i * 4]} ${ramp[i * 4 + 1]} ${ramp[i * 4 + 2]})`;
        context.fillRect(i * width / STEPS, height, width / STEPS + 1, RAMP_TALL);
      }
    if (stops) {
      context.fillStyle = "#fff";
      context.fillRect((-display.exposure - low) / (high - low) * width, 0, 1, height); // what is shown white
    }
    const unit = stops ? " EV" : "";
    const said = (v) => Number((logs && !stops ? 2 ** v : v).toPrecision(3));
    const parts = [`${name}${said(low)} to ${said(high)}${unit}`];
    if (count > 0 && zero > 0) parts.push(`${Math.round(100 * zero / count)} % black`);
    if (bad > 0) parts.push(`${bad} not finite`);
    this.text.textContent = parts.join(", ");
  }
}

// SSIM and FLIP on the page: their maps on the canvas, their figures and the colours' legend.
import { magnitudes, STEPS } from "../picture/color_map.js";
import { short } from "../picture/value_overlay.js";

// As Display has it: dark where the two are alike, in both maps.
export const MAP_DISPLAY = { shownAs: "colour", low: 0, high: 1, logarithmic: false, dither: false, clipMarks: false,
                      exposure: 0, gamma: 1, curve: "linear", behind: "black" };
const ENDS = { ssim: ["1 alike", "0 or less"], flip: ["0 alike", "1 unlike"] };

export class PerceptualView {
  constructor(elements, metrics) {
    this.at = elements;
    this.metrics = metrics;
    const canvas = elements.legend.querySelector("canvas"), ramp = magnitudes(), context = canvas.getContext("2d");
    for (let i = 0; i < STEPS; i++) {
      context.fillStyle = `rgb(${ramp[i * 4]} ${ramp[i * 4 + 1]} ${ramp[i * 4 + 2]})`;
      context.fillRect(i * canvas.width / STEPS, 0, canvas.width / STEPS + 1, canvas.height);
    }
  }

  // What Picture draws instead of the layers: the map, which begins where what was in sight did.
  // Null when no map is asked for, or there is none yet.
  look(compare, { zoom, x, y, canvas }) {
    const { found } = this.metrics;
    if (!compare.metric || !found) return null;
    const viewport = { zoom, x: x - found.area.x0, y: y - found.area.y0, canvas };
    return { first: found.maps[compare.metric], other: null, viewport, display: MAP_DISPLAY, compare };
  }

  // The map's values by the picture's pixels.
  values(compare) {
    if (!compare.metric || !this.metrics.found) return null;
    return { at: (x, y) => { const v = this.metrics.valueAt(compare.metric, { x, y }); return v === null ? null : [v]; } };
  }

  // What the probe says of a pixel.
  describe(point) {
    const [ssim, flip] = ["ssim", "flip"].map((metric) => this.metrics.valueAt(metric, point));
    return ssim === null ? "" : ` | SSIM ${short(ssim)}  FLIP ${short(flip)}`;
  }

  // `live`: more of the two comes; `unfit`: they are no pictures.
  show(compare, live, unfit) {
    const { at, metrics } = this;
    at.legend.hidden = !compare.metric || !metrics.found;
    if (compare.metric) ENDS[compare.metric].forEach((text, i) => { at.legendEnds[i].textContent = text; });
    at.alike.textContent = compare.mode === "off" ? "" : unfit ? "SSIM and FLIP need layers that are shown as pictures." : this.figures(live);
  }

  figures(live) {
    const { found, current, tooMany, failed, wanted } = this.metrics;
    if (failed) return "SSIM and FLIP could not be computed.";
    if (tooMany) return "SSIM and FLIP take at most four million pixels in sight: zoom in.";
    if (!found || (!current && !live)) return wanted ? "SSIM, FLIP: computing" : "";
    const { ssim, flip, count } = found, said = (v) => v.toFixed(4);
    return `SSIM ${said(ssim)}, FLIP ${said(flip.mean)} (weighted quartiles ${flip.quartiles.map(said).join(", ")}) as shown over ${count} pixels${live ? " so far" : ""}`;
  }
}

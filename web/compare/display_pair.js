// Two layers as the screen shows them, the input of perceptual metrics, as server/compare/display_transform.h has
// it. A number v becomes srgb(clip(curve(v * 2^exposure)))^(1 / gamma), as in the shader.
import { halfTable } from "../picture/half.js";

const filmic = (v) => { const x = Math.max(v, 0) * 0.6; return x > 1e6 ? 1 : x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); };

function encoder({ exposure, gamma, curve }) {
  const scale = 2 ** exposure, power = 1 / gamma;
  return (v) => {
    const w = curve === "filmic" ? filmic(v * scale) : v * scale, linear = w > 0 ? Math.min(w, 1) : 0;
    const encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
    return power === 1 ? encoded : encoded ** power;
  };
}

// `first`, `other`: {numbers, seen}, three numbers a pixel (Uint16Array: half floats) and a byte,
// whether the pixel is there. Gives {width, height, reference: 3 arrays, test: 3 arrays, counts, count}:
// where one of the two is not there or not finite neither counts and both are black.
export function displayPair({ width, height, first, other, view }) {
  const area = width * height, encode = encoder(view);
  const planes = () => [0, 1, 2].map(() => new Float32Array(area));
  const out = { width, height, reference: planes(), test: planes(), counts: new Uint8Array(area), count: 0 };
  // Of half floats there are but 65536.
  const table = (numbers) => numbers instanceof Uint16Array ? Float32Array.from(halfTable(), encode) : null;
  const shows = [first, other].map(({ numbers }) => {
    const shown = table(numbers), halves = halfTable();
    return shown ? { finite: (i) => Number.isFinite(halves[numbers[i]]), at: (i) => shown[numbers[i]] }
      : { finite: (i) => Number.isFinite(numbers[i]), at: (i) => encode(numbers[i]) };
  });
  for (let i = 0, k = 0; i < area; i++, k += 3) {
    if (!first.seen[i] || !other.seen[i]) continue;
    if (!shows.every(({ finite }) => finite(k) && finite(k + 1) && finite(k + 2))) continue;
    out.counts[i] = 1;
    out.count++;
    for (let c = 0; c < 3; c++) {
      out.reference[c][i] = shows[0].at(k + c);
      out.test[c][i] = shows[1].at(k + c);
    }
  }
  return out;
}

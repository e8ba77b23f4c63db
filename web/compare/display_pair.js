// Two layers as the screen shows them, the input of perceptual metrics, as server/compare/display_transform.h has
// it. A pixel v becomes srgb(curve(v * 2^exposure))^(1 / gamma), as in the shader.
import { halfTable } from "../picture/half.js";
import { channelShown, isByChannel, pixelShown, srgb } from "../picture/view_transform.js";

const asSeen = (gamma) => gamma === 1 ? srgb : (v) => srgb(v) ** (1 / gamma);

// What fills `out` with the pixel from number k on. Of half floats there are but 65536: curves of single
// channels are in a table.
function shower(numbers, { exposure, gamma, curve }) {
  const scale = 2 ** exposure, seen = asSeen(gamma), halves = halfTable(), isHalf = numbers instanceof Uint16Array;
  if (isHalf && isByChannel(curve)) {
    const table = Float32Array.from(halves, (v) => seen(channelShown(curve, v * scale)));
    return (k, out) => { for (let c = 0; c < 3; c++) out[c] = table[numbers[k + c]]; };
  }
  return (k, out) => {
    for (let c = 0; c < 3; c++) out[c] = (isHalf ? halves[numbers[k + c]] : numbers[k + c]) * scale;
    pixelShown(curve, out);
    for (let c = 0; c < 3; c++) out[c] = seen(out[c]);
  };
}

function finder(numbers) {
  const halves = halfTable();
  return numbers instanceof Uint16Array ? (i) => Number.isFinite(halves[numbers[i]]) : (i) => Number.isFinite(numbers[i]);
}

// `first`, `other`: {numbers, seen}, three numbers a pixel (Uint16Array: half floats) and a byte,
// whether the pixel is there. Gives {width, height, reference: 3 arrays, test: 3 arrays, counts, count}:
// where one of the two is not there or not finite neither counts and both are black.
export function displayPair({ width, height, first, other, view }) {
  const area = width * height, pixel = [0, 0, 0];
  const planes = () => [0, 1, 2].map(() => new Float32Array(area));
  const out = { width, height, reference: planes(), test: planes(), counts: new Uint8Array(area), count: 0 };
  const shows = [first, other].map(({ numbers }) => shower(numbers, view)), finite = [first, other].map(({ numbers }) => finder(numbers)), both = [out.reference, out.test];
  for (let i = 0, k = 0; i < area; i++, k += 3) {
    if (!first.seen[i] || !other.seen[i]) continue;
    if (!finite.every((is) => is(k) && is(k + 1) && is(k + 2))) continue;
    out.counts[i] = 1;
    out.count++;
    for (let which = 0; which < 2; which++) {
      shows[which](k, pixel);
      for (let c = 0; c < 3; c++) both[which][c][i] = pixel[c];
    }
  }
  return out;
}

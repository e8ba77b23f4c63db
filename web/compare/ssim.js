// Structural similarity of two pictures as shown: Wang, Bovik, Sheikh and Simoncelli 2004, equation
// 13, with a Gaussian window of 11 x 11, sigma 1.5, K1 = 0.01, K2 = 0.03, on Rec. 709 luma in [0, 1].
// As server/compare/ssim.c: windows are cut at the border and at pixels that do not count.
import { convolve } from "./convolve.js";

const RADIUS = 5, SIGMA = 1.5, C1 = 0.01 ** 2, C2 = 0.03 ** 2;

function window() {
  const weights = Float64Array.from({ length: 2 * RADIUS + 1 }, (_, k) => Math.exp(-((k - RADIUS) ** 2) / (2 * SIGMA * SIGMA)));
  const sum = weights.reduce((a, b) => a + b, 0);
  return weights.map((w) => w / sum);
}

// {map, mean}: the map is 1 where the windows around are the same and where a pixel does not count;
// the mean is over windows that lie wholly in the picture, or over all when none does.
export function ssim({ width, height, reference, test, counts }) {
  const area = width * height, w = window();
  const sums = Array.from({ length: 6 }, () => new Float32Array(area));
  const luma = (rgb, i) => 0.2126 * rgb[0][i] + 0.7152 * rgb[1][i] + 0.0722 * rgb[2][i];
  for (let i = 0; i < area; i++) {
    const x = luma(reference, i), y = luma(test, i);
    [counts[i], x, y, x * x, y * y, x * y].forEach((v, k) => { sums[k][i] = v; });
  }
  for (const values of sums) convolve(values, width, height, w, w, false, values);
  const map = new Float32Array(area);
  for (let i = 0; i < area; i++) map[i] = counts[i] ? similarity(sums, i) : 1;
  return { map, mean: meanOf(map, width, height, counts) };
}

function similarity([weight, xs, ys, xxs, yys, xys], i) {
  const n = weight[i], x = xs[i] / n, y = ys[i] / n;
  const xx = Math.max(xxs[i] / n - x * x, 0), yy = Math.max(yys[i] / n - y * y, 0);
  // No more than the deviations allow: rounding must not tell what is flat and alike apart.
  const most = Math.sqrt(xx * yy), xy = Math.min(Math.max(xys[i] / n - x * y, -most), most);
  return (2 * x * y + C1) * (2 * xy + C2) / ((x * x + y * y + C1) * (xx + yy + C2));
}

function meanOf(map, width, height, counts) {
  const edge = width > 2 * RADIUS && height > 2 * RADIUS ? RADIUS : 0;
  let sum = 0, count = 0;
  for (let y = edge; y < height - edge; y++)
    for (let x = edge; x < width - edge; x++) {
      const i = y * width + x;
      if (!counts[i]) continue;
      sum += map[i];
      count++;
    }
  return count > 0 ? sum / count : 1;
}

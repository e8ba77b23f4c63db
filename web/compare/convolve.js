// Separable sums over what is around each pixel, along the rows, then along the columns: as
// server/compare/convolve.c has them.

// `across` and `down`: weights of the pixels from -r to r, 2r + 1 of them. `replicate`: beyond the
// border lie the border's own values; else nothing does.
export function convolve(input, width, height, across, down, replicate, out = new Float32Array(input.length)) {
  const between = new Float32Array(input.length);
  sumAcross(input, width, height, across, replicate, between);
  sumDown(between, width, height, down, replicate, out);
  return out;
}

function sumAcross(input, width, height, weights, replicate, out) {
  const radius = weights.length >> 1, line = new Float64Array(width + 2 * radius), taps = weights.length;
  for (let y = 0; y < height; y++) {
    const at = y * width;
    line.set(input.subarray(at, at + width), radius);
    line.fill(replicate ? input[at] : 0, 0, radius);
    line.fill(replicate ? input[at + width - 1] : 0, radius + width);
    for (let x = 0; x < width; x++) {
      let sum = 0;
      for (let k = 0; k < taps; k++) sum += weights[k] * line[x + k];
      out[at + x] = sum;
    }
  }
}

function sumDown(input, width, height, weights, replicate, out) {
  const radius = weights.length >> 1, line = new Float64Array(width);
  for (let y = 0; y < height; y++) {
    line.fill(0);
    for (let k = 0; k < weights.length; k++) {
      const v = y + k - radius;
      if (!replicate && (v < 0 || v >= height)) continue;
      const at = Math.min(height - 1, Math.max(0, v)) * width, weight = weights[k];
      for (let x = 0; x < width; x++) line[x] += weight * input[at + x];
    }
    out.set(line, y * width);
  }
}

// Colours as FLIP has them, as server/compare/flip_color.c: linearised CIELAB, in which contrast
// sensitivity is measured, and CIELAB with Hunt's effect. D65; the matrix of sRGB. Colours are three
// numbers that the caller holds: a picture has millions.

const WHITE = [0.950428545, 1, 1.088900371];
const TO_XYZ = [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794,
                2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897,
                1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382];
const FROM_XYZ = [3.241003275, -1.537398934, -0.498615861,
                  -0.969224334, 1.875930071, 0.041554224,
                  0.055639423, -0.204011202, 1.057148933]; // its inverse

const row = (m, i, a, b, c) => m[i] * a + m[i + 1] * b + m[i + 2] * c;
const linearOf = (v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;

// sRGB in [0, 1] to Y, Cx, Cz.
export function opponent(r, g, b, out) {
  const lr = linearOf(r), lg = linearOf(g), lb = linearOf(b);
  const x = row(TO_XYZ, 0, lr, lg, lb) / WHITE[0], y = row(TO_XYZ, 3, lr, lg, lb), z = row(TO_XYZ, 6, lr, lg, lb) / WHITE[2];
  out[0] = 116 * y - 16;
  out[1] = 500 * (x - y);
  out[2] = 200 * (y - z);
}

const DELTA = 6 / 29;
const lightness = (v) => v > DELTA ** 3 ? Math.cbrt(v) : v / (3 * DELTA * DELTA) + 4 / 29;
const clip = (v) => Math.min(Math.max(v, 0), 1);

function huntOfLinear(r, g, b, out) {
  const x = lightness(row(TO_XYZ, 0, r, g, b) / WHITE[0]), y = lightness(row(TO_XYZ, 3, r, g, b)), z = lightness(row(TO_XYZ, 6, r, g, b) / WHITE[2]);
  out[0] = 116 * y - 16;
  out[1] = 0.01 * out[0] * 500 * (x - y);
  out[2] = 0.01 * out[0] * 200 * (y - z);
}

// Y, Cx, Cz, cut to what a screen can show, to L*, a*, b* whose a and b grow with L.
export function hunt(Y, Cx, Cz, out) {
  const y = (Y + 16) / 116, x = (y + Cx / 500) * WHITE[0], z = (y - Cz / 200) * WHITE[2];
  huntOfLinear(clip(row(FROM_XYZ, 0, x, y, z)), clip(row(FROM_XYZ, 3, x, y, z)), clip(row(FROM_XYZ, 6, x, y, z)), out);
}

// HyAB: |dL| + |(da, db)|.
export const distance = (L, a, b) => Math.abs(L) + Math.sqrt(a * a + b * b);

// That of the screen's green and blue, which is the largest there is.
export function largestDistance() {
  const green = [0, 0, 0], blue = [0, 0, 0];
  huntOfLinear(0, 1, 0, green);
  huntOfLinear(0, 0, 1, blue);
  return distance(green[0] - blue[0], green[1] - blue[1], green[2] - blue[2]);
}

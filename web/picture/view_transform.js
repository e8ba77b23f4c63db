// From scene light to the light of a screen: the formulas of server/image/view_transform.h, which has
// their sources, for the page's own numbers and for the shader.

export const CURVES = ["linear", "filmic", "agx"];

const LIGHT_MAX = 1e9;
const AGX_LEAST_EV = -12.47393, AGX_RANGE = 4.026069 - AGX_LEAST_EV;
const SIGMOID = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232]; // from x^6 down
const REC2020_OF_709 = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]];
const REC709_OF_2020 = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
const INSET = [[0.856627153315983, 0.0951212405381588, 0.0482516061458583],
               [0.137318972929847, 0.761241990602591, 0.101439036467562],
               [0.11189821299995, 0.0767994186031903, 0.811302368396859]];
const OUTSET = [[1.1271005818144368, -0.11060664309660323, -0.016493938717834573],
                [-0.1413297634984383, 1.157823702216272, -0.016493938717834257],
                [-0.14132976349843826, -0.11060664309660294, 1.2519364065950405]];

// NaN gives 0.
const clip = (v, most) => v > 0 ? Math.min(v, most) : 0;
const times = (a, b) => a.map((row) => [0, 1, 2].map((c) => row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c]));
const IN = times(INSET, REC2020_OF_709);

function turn(matrix, v) {
  const [x, y, z] = v;
  for (let r = 0; r < 3; r++) v[r] = matrix[r][0] * x + matrix[r][1] * y + matrix[r][2] * z;
}

function sigmoid(v) {
  const x = clip((Math.log2(Math.max(v, 1e-10)) - AGX_LEAST_EV) / AGX_RANGE, 1);
  return SIGMOID.reduce((sum, factor) => sum * x + factor, 0);
}

function agx(v) {
  turn(IN, v);
  for (let c = 0; c < 3; c++) v[c] = sigmoid(v[c]);
  turn(OUTSET, v);
  for (let c = 0; c < 3; c++) v[c] = Math.max(v[c], 0) ** 2.2;
  turn(REC709_OF_2020, v);
}

// One channel of a curve that leaves channels apart.
export const isByChannel = (curve) => curve !== "agx";
export function channelShown(curve, light) {
  const v = clip(light, LIGHT_MAX), x = 0.6 * v;
  return clip(curve === "filmic" ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : v, 1);
}

// Makes of a pixel's light, exposed already, what is shown: linear, in [0, 1].
export function pixelShown(curve, v) {
  if (isByChannel(curve)) {
    for (let c = 0; c < 3; c++) v[c] = channelShown(curve, v[c]);
    return;
  }
  for (let c = 0; c < 3; c++) v[c] = clip(v[c], LIGHT_MAX);
  agx(v);
  for (let c = 0; c < 3; c++) v[c] = clip(v[c], 1);
}

export const srgb = (v) => v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;

const number = (v) => Number.isInteger(v) ? `${v}.0` : String(v);
// Columns come first in GLSL.
const matrix = (rows) => `mat3(${[0, 1, 2].flatMap((c) => rows.map((row) => number(row[c]))).join(", ")})`;

// The function `vec3 viewed(vec3)` of a curve for the shader, of light that is exposed already.
export const viewedText = (curve) => ({
  linear: "vec3 viewed(vec3 v) { return clamp(v, 0.0, 1.0); }",
  filmic: `vec3 viewed(vec3 v) {
  v = clamp(v, 0.0, ${number(LIGHT_MAX)}) * 0.6;
  return clamp(v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14), 0.0, 1.0);
}`,
  agx: `vec3 viewed(vec3 v) {
  v = ${matrix(IN)} * clamp(v, 0.0, ${number(LIGHT_MAX)});
  v = clamp((log2(max(v, 1e-10)) - ${number(AGX_LEAST_EV)}) / ${number(AGX_RANGE)}, 0.0, 1.0);
  v = ${SIGMOID.slice(1).reduce((text, factor) => `(${text}) * v + vec3(${number(factor)})`, `vec3(${number(SIGMOID[0])})`)};
  v = pow(max(${matrix(OUTSET)} * v, 0.0), vec3(2.2));
  return clamp(${matrix(REC709_OF_2020)} * v, 0.0, 1.0);
}`,
})[curve];

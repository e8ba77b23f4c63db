// How different two pictures look when they alternate at a place: LDR-FLIP after Andersson, Nilsson,
// Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
// Images", sections 4.1, 4.2 and 5, as server/compare/flip.c. FLIP-like: the pictures are linear
// numbers as the viewer shows them, and pixels that do not count are black in both and left out.
import { convolve } from "./convolve.js";
import { distance, hunt, largestDistance, opponent } from "./flip_color.js";

// Pixels a degree of visual angle: of a screen 0.7 m wide with 3840 pixels, seen from 0.7 m.
export const PPD = 67.0206432765;

const COLOR_POWER = 0.7, FEATURE_POWER = 0.5; // exponents of colour and of features
const LARGE_FROM = 0.4, LARGE_AT = 0.95; // where large colour errors begin, and what they get
const FEATURE_WIDTH = 0.082; // degrees, of the human edge detector
// Contrast sensitivity: sums of Gaussians in degrees, [a, b] each; table 1 of the paper.
const SENSITIVITY = [[[1, 0.0047]], [[1, 0.0053]], [[34.1, 0.04], [13.5, 0.025]]];

const sumOf = (weights) => weights.reduce((a, b) => a + b, 0);
const weightsOf = (radius, weight) => Float64Array.from({ length: 2 * radius + 1 }, (_, k) => weight(k - radius));

// A channel's filter is a sum of separable ones whose weights together sum to one.
function filterChannel(values, width, height, gaussians, ppd) {
  const radius = Math.ceil(3 * Math.sqrt(0.04 / (2 * Math.PI ** 2)) * ppd);
  const parts = gaussians.map(([a, b]) => {
    const weights = weightsOf(radius, (k) => Math.exp(-(Math.PI ** 2) * (k / ppd) * (k / ppd) / b)), sum = sumOf(weights);
    return { weights: weights.map((w) => w / sum), share: a * Math.sqrt(Math.PI / b) * sum * sum };
  });
  const total = sumOf(parts.map(({ share }) => share));
  const filtered = parts.map(({ weights }) => convolve(values, width, height, weights, weights, true));
  for (let i = 0; i < values.length; i++) {
    let sum = 0;
    for (let g = 0; g < parts.length; g++) sum += parts[g].share / total * filtered[g][i];
    values[i] = sum;
  }
}

// Weights below zero sum to -1, those above to 1.
function balance(weights) {
  const above = sumOf(weights.filter((w) => w >= 0)), below = -sumOf(weights.filter((w) => w < 0));
  return weights.map((w) => w / (w < 0 ? below : above));
}

// The Gaussian of features, and its first and second derivative.
function featureWeights(ppd) {
  const sigma = 0.5 * FEATURE_WIDTH * ppd, radius = Math.ceil(3 * sigma), g = (k) => Math.exp(-k * k / (2 * sigma * sigma));
  const along = weightsOf(radius, g), sum = sumOf(along);
  return [along.map((w) => w / sum), balance(weightsOf(radius, (k) => -k * g(k))), balance(weightsOf(radius, (k) => (k * k / (sigma * sigma) - 1) * g(k)))];
}

// The length of a derivative's two components.
function feature(luminance, width, height, derivative, along) {
  const across = convolve(luminance, width, height, derivative, along, true), down = convolve(luminance, width, height, along, derivative, true);
  for (let i = 0; i < across.length; i++) across[i] = Math.sqrt(across[i] * across[i] + down[i] * down[i]);
  return across;
}

// One picture, as it is perceived.
function perceive(shown, width, height, ppd) {
  const area = width * height, lab = [0, 1, 2].map(() => new Float32Array(area)), luminance = new Float32Array(area), v = [0, 0, 0];
  for (let i = 0; i < area; i++) {
    opponent(shown[0][i], shown[1][i], shown[2][i], v);
    for (let c = 0; c < 3; c++) lab[c][i] = v[c];
    luminance[i] = (lab[0][i] + 16) / 116;
  }
  const [along, first, second] = featureWeights(ppd);
  const edge = feature(luminance, width, height, first, along), point = feature(luminance, width, height, second, along);
  lab.forEach((values, c) => filterChannel(values, width, height, SENSITIVITY[c], ppd));
  for (let i = 0; i < area; i++) {
    hunt(lab[0][i], lab[1][i], lab[2][i], v);
    for (let c = 0; c < 3; c++) lab[c][i] = v[c];
  }
  return { lab, edge, point };
}

function errorAt(p, q, i, largest) {
  const away = distance(p.lab[0][i] - q.lab[0][i], p.lab[1][i] - q.lab[1][i], p.lab[2][i] - q.lab[2][i]) ** COLOR_POWER;
  const large = LARGE_FROM * largest;
  const color = away < large ? LARGE_AT / large * away : LARGE_AT + (away - large) / (largest - large) * (1 - LARGE_AT);
  const feature = (Math.max(Math.abs(p.edge[i] - q.edge[i]), Math.abs(p.point[i] - q.point[i])) / Math.SQRT2) ** FEATURE_POWER;
  return Math.min(Math.min(color, 1) ** Math.max(1 - feature, 0), 1);
}

// Mean, largest, and below which errors a quarter, half, three quarters of their sum lie.
function pool(errors) {
  if (errors.length === 0) return { mean: 0, max: 0, quartiles: [0, 0, 0] };
  const sorted = errors.sort(), quartiles = [];
  const sum = sumOf(Float64Array.from(sorted));
  for (let i = 0, soFar = 0; i < sorted.length && quartiles.length < 3; i++) {
    soFar += sorted[i];
    while (quartiles.length < 3 && soFar >= 0.25 * (quartiles.length + 1) * sum) quartiles.push(sorted[i]);
  }
  while (quartiles.length < 3) quartiles.push(sorted[sorted.length - 1]);
  return { mean: sum / sorted.length, max: sorted[sorted.length - 1], quartiles };
}

// {map, mean, max, quartiles}: errors in [0, 1], 0 where no difference is visible.
export function flip({ width, height, reference, test, counts, count }, ppd = PPD) {
  const p = perceive(reference, width, height, ppd), q = perceive(test, width, height, ppd);
  const largest = largestDistance() ** COLOR_POWER, map = new Float32Array(width * height), errors = new Float32Array(count);
  for (let i = 0, k = 0; i < map.length; i++) {
    if (!counts[i]) continue;
    map[i] = errorAt(p, q, i, largest);
    errors[k++] = map[i];
  }
  return { map, ...pool(errors) };
}

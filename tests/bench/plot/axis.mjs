// Axes: from values to places, with ticks and their labels.

// Steps within a decade, by how many decades are to be seen: never fewer than two ticks, never a crowd.
const STEPS = [[0.35, [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9]], [0.8, [1, 1.5, 2, 3, 5, 7]], [2.4, [1, 2, 5]], [9, [1]]];

export function short(v) {
  const a = Math.abs(v), digits = (x) => String(Number(x.toPrecision(3)));
  if (v === 0) return "0";
  if (a >= 1e9) return `${digits(v / 1e9)}G`;
  if (a >= 1e6) return `${digits(v / 1e6)}M`;
  if (a >= 1e4) return `${digits(v / 1e3)}k`;
  if (a >= 1e3) return String(Math.round(v));
  return a >= 1e-3 ? digits(v) : v.toExponential(0).replace("e-", "e−");
}

// Over positive values, from `from` to `to` (pixels): {at(value), ticks: [[value, label], ...], minor}.
export function logAxis(values, from, to, wanted) {
  let low = Math.log10(Math.min(...values)), high = Math.log10(Math.max(...values));
  const margin = Math.max(0.04 * (high - low), 0.03);
  [low, high] = [low - margin, high + margin];
  const at = (v) => from + (Math.log10(v) - low) / (high - low) * (to - from);
  const steps = STEPS.find(([most]) => high - low <= most)?.[1] ?? [1], inside = (v) => Math.log10(v) >= low && Math.log10(v) <= high;
  const decades = Array.from({ length: Math.ceil(high) - Math.floor(low) + 1 }, (_, i) => 10 ** (Math.floor(low) + i));
  const minor = decades.flatMap((d) => [1, 2, 3, 4, 5, 6, 7, 8, 9].map((m) => m * d)).filter(inside);
  const ticks = (wanted ?? decades.flatMap((d) => steps.map((m) => Number((m * d).toPrecision(3))))).filter(inside);
  return { at, ticks: ticks.map((v) => [v, short(v)]), minor };
}

// From 0, or from `least` where that is said, to the largest.
export function linearAxis(values, from, to, wanted) {
  const most = Math.max(...values) * 1.06 || 1;
  const at = (v) => from + v / most * (to - from);
  const raw = most / 5, unit = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 2.5, 5, 10].find((m) => m * unit >= raw) * unit;
  const ticks = wanted ?? Array.from({ length: Math.floor(most / step) + 1 }, (_, i) => i * step);
  return { at, ticks: ticks.map((v) => [v, short(Number(v.toPrecision(6)))]), minor: [] };
}

// Labels that would cover each other give way: those of `ticks` [[value, label]] at least `gap` pixels apart.
export function thinned(ticks, at, gap) {
  let last = -Infinity;
  return ticks.filter(([v]) => {
    if (Math.abs(at(v) - last) < gap) return false;
    last = at(v);
    return true;
  });
}

// What the figures amount to: how many samples, or seconds, the plain average needs for the same
// error, by interpolation in log-log.

export const median = (values) => {
  const sorted = values.slice().sort((a, b) => a - b), n = sorted.length;
  return n === 0 ? NaN : n % 2 ? sorted[(n - 1) / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
};

// The x at which a falling curve of [x, error] reaches `error`; beyond its ends along its last leg.
export function reach(points, error) {
  const p = points.map(([x, y]) => [Math.log(x), Math.log(y)]), want = Math.log(error);
  if (p.length < 2) return null;
  let leg = p.findIndex((_, i) => i > 0 && (p[i - 1][1] - want) * (p[i][1] - want) <= 0);
  const outside = leg < 0;
  if (outside) leg = want > p[0][1] ? 1 : p.length - 1;
  const [[x0, y0], [x1, y1]] = [p[leg - 1], p[leg]];
  if (!(y1 < y0)) return null;
  return { x: Math.exp(x0 + (x1 - x0) * (want - y0) / (y1 - y0)), outside };
}

// `part`: which of a row's figures are the errors.
export const curve = (rows, scene, method, x, part = "judged") => rows.filter((r) => r.scene === scene && r.method === method)
  .sort((a, b) => a.spp - b.spp).map((r) => [x(r), r[part].rmse]);

// The y of a curve of [x, y] at x, beyond its ends along its last leg: {y, outside}; null of less than two points.
export function along(points, x) {
  if (points.length < 2) return null;
  const inside = points.findIndex(([x1], i) => i > 0 && points[i - 1][0] <= x && x <= x1), outside = inside < 0;
  const leg = !outside ? inside : x < points[0][0] ? 1 : points.length - 1;
  const [[x0, y0], [x1, y1]] = [points[leg - 1], points[leg]].map((p) => p.map(Math.log));
  return { y: Math.exp(y0 + (y1 - y0) * (Math.log(x) - x0) / (x1 - x0)), outside };
}

// The error of a curve of [x, error] at x; NaN beyond its ends.
export function errorAt(points, x) {
  const found = along(points, x);
  return found && !found.outside ? found.y : NaN;
}

// CPU seconds of the filter itself, of a row or of what it cost with another instruction set.
export const filterSeconds = ({ cpu_s }) => ["shadow", "indirect", "lens", "lens_relight"].reduce((sum, stage) => sum + (cpu_s[stage] ?? 0), 0);

// For every scene, method and count: factors against a plainer method.
export function equalError(rows, against, part = "judged") {
  const found = [];
  for (const row of rows) {
    if (row.method === against) continue;
    const samples = reach(curve(rows, row.scene, against, (r) => r.spp, part), row[part].rmse);
    const seconds = reach(curve(rows, row.scene, against, (r) => r.cpu_s.judged, part), row[part].rmse);
    if (!samples || !seconds) continue;
    found.push({ scene: row.scene, method: row.method, spp: row.spp, against,
      samples: samples.x / row.spp, seconds: seconds.x / row.cpu_s.judged,
      free: seconds.x / (row.cpu_s.judged - filterSeconds(row)), // were the filter free
      extrapolated: samples.outside || seconds.outside });
  }
  return found;
}

// What the figures amount to: how many samples, or seconds, the plain average needs for the same
// error, by interpolation in log-log; and the bounds that a release must reach.

const median = (values) => {
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

const curve = (rows, scene, method, x) => rows.filter((r) => r.scene === scene && r.method === method)
  .sort((a, b) => a.spp - b.spp).map((r) => [x(r), r.penumbra.rmse]);

// For every scene, method and count: factors against a plainer method.
export function equalError(rows, against) {
  const found = [];
  for (const row of rows) {
    if (row.method === against) continue;
    const samples = reach(curve(rows, row.scene, against, (r) => r.spp), row.penumbra.rmse);
    const seconds = reach(curve(rows, row.scene, against, (r) => r.cpu_s.judged), row.penumbra.rmse);
    if (!samples || !seconds) continue;
    found.push({ scene: row.scene, method: row.method, spp: row.spp, against,
      samples: samples.x / row.spp, seconds: seconds.x / row.cpu_s.judged,
      free: seconds.x / (row.cpu_s.judged - (row.cpu_s.shadow ?? 0)), // were the filter free
      extrapolated: samples.outside || seconds.outside });
  }
  return found;
}

// CPU seconds of the filter itself.
const filterSeconds = (row) => row.cpu_s.shadow;


const monotone = (rows, scene) => {
  const points = curve(rows, scene, "sheared", (r) => r.spp).filter(([spp]) => spp >= 4 && spp <= 256);
  return points.length > 1 && points.every(([, y], i) => i === 0 || y < points[i - 1][1]);
};

// The bounds, each with what was measured: {figure, value, relation, bound, unit, scenes}; those for
// which nothing was measured are left out. bound null: a figure to know, not to reach.
export function bounds(rows) {
  const at9 = (method) => rows.filter((r) => r.method === method && r.spp === 9);
  const pairs = (method, other) => at9(method).map((r) => [r, at9(other).find((o) => o.scene === r.scene)])
    .filter(([, o]) => o);
  const factors = equalError(rows, "average").filter((f) => f.method === "sheared" && f.spp === 9);
  const toAxis = equalError(rows, "axis_aligned").filter((f) => f.method === "sheared" && f.spp === 9);
  const megapixels = (r) => r.side_px * r.side_px / 1e6;
  const sheared = at9("sheared"), scenes = [...new Set(rows.filter((r) => r.method === "sheared").map((r) => r.scene))];
  const list = [
    ["sheared, 9 spp: average's RMSE over its", pairs("sheared", "average").map(([s, a]) => a.penumbra.rmse / s.penumbra.rmse), ">=", 5, "times"],
    ["sheared, 9 spp: axis-aligned's RMSE over its", pairs("sheared", "axis_aligned").map(([s, a]) => a.penumbra.rmse / s.penumbra.rmse), ">=", 1.8, "times"],
    ["sheared, 9 spp: average's samples for equal error", factors.map((f) => f.samples), ">=", 12, "times"],
    ["sheared, 9 spp: average's CPU time for equal error", factors.map((f) => f.seconds), ">=", 8, "times"],
    ["  the same, were the filter free", factors.map((f) => f.free), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's samples for equal error", toAxis.map((f) => f.samples), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's CPU time for equal error", toAxis.map((f) => f.seconds), ">=", null, "times"],
    ["sheared, 9 spp: filter's CPU time per megapixel", sheared.map((r) => filterSeconds(r) / megapixels(r)), "<=", 0.25, "s"],
    ["sheared, 9 spp: filter's share of the frame's CPU time", sheared.map((r) => filterSeconds(r) / r.cpu_s.total), "<=", 0.2, "ratio"],
    ["axis-aligned, 9 spp: its CPU time over sheared's", pairs("axis_aligned", "sheared").map(([a, s]) =>
      filterSeconds(a) / filterSeconds(s)), "<=", 1 / 3, "ratio"],
  ].map(([figure, values, relation, bound, unit]) => ({ figure, values: values.filter(Number.isFinite), relation, bound, unit }))
    .filter((b) => b.values.length > 0)
    .map((b) => ({ figure: b.figure, value: median(b.values), relation: b.relation, bound: b.bound, unit: b.unit,
      least: Math.min(...b.values), most: Math.max(...b.values), scenes: b.values.length }));
  if (scenes.length > 0)
    list.push({ figure: "sheared: scenes whose error falls from 4 to 256 spp", relation: ">=", bound: scenes.length,
      value: scenes.filter((s) => monotone(rows, s)).length, unit: "scenes", scenes: scenes.length });
  return list.map((b) => ({ ...b,
    ok: b.bound === null || (b.relation === ">=" ? b.value >= b.bound : b.value <= b.bound) }));
}

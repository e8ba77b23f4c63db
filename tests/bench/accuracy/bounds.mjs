// The bounds that a release must reach, each with what was measured: {figure, value, relation, bound,
// unit, least, most, scenes, ok}; one for which nothing was measured has the value null and ok null.
// bound null: a figure to know, not to reach. The value is the median over scenes, or the worst of them where
// the figure says "every scene".
import { curve, equalError, errorAt, filterSeconds, median } from "./factors.mjs";

const steps = (rows, scene, method, most) => curve(rows, scene, method, (r) => r.spp).filter(([spp]) => spp >= 4 && spp <= most);
const falls = (points) => points.every(([, y], i) => i === 0 || y < points[i - 1][1]);
const at = (rows, method, spp) => rows.filter((r) => r.method === method && r.spp === spp);
const pairs = (rows, method, other, spp) => at(rows, method, spp)
  .map((r) => [r, at(rows, other, spp).find((o) => o.scene === r.scene)]).filter(([, o]) => o);
const timesLower = (found) => found.map(([r, plainer]) => plainer.judged.rmse / r.judged.rmse);
const worst = (values) => values.length > 0 ? [Math.max(...values)] : [];
const secondsPerMegapixel = (r) => filterSeconds(r) / r.megapixels;
const secondsWith = (rows, isa) => rows.filter((r) => r.with_isa?.isa === isa).map((r) => filterSeconds(r.with_isa) / r.megapixels);

// Scenes whose error falls with every step of samples, of those measured with more than one count.
function monotone(rows, method, most = 256) {
  const scenes = [...new Set(rows.filter((r) => r.method === method).map((r) => r.scene))];
  const curves = scenes.map((s) => steps(rows, s, method, most)).filter((points) => points.length > 1);
  return { figure: `${method}: scenes whose error falls from 4 to ${most} spp`, relation: ">=", bound: curves.length, unit: "scenes",
    values: curves.length > 0 ? [curves.filter(falls).length] : [], scenes: curves.length };
}

// Of these, scenes on which every step is larger than what the reference leaves in doubt of both errors.
function beyondDoubt(rows, method, most = 256) {
  const scenes = [...new Set(rows.filter((r) => r.method === method).map((r) => r.scene))];
  const doubt = (r) => r.judged.rmse * (r.judged.doubt ?? 0);
  const clear = (scene) => rows.filter((r) => r.scene === scene && r.method === method && r.spp >= 4 && r.spp <= most)
    .sort((x, y) => x.spp - y.spp)
    .every((r, i, all) => i === 0 || all[i - 1].judged.rmse - r.judged.rmse > Math.hypot(doubt(r), doubt(all[i - 1])));
  return ["  on which every step is beyond the reference's doubt", scenes.length > 0 ? [scenes.filter(clear).length] : [], ">=", null, "scenes"];
}

function shadows(rows) {
  const factors = equalError(rows, "average").filter((f) => f.method === "sheared" && f.spp === 9);
  const toAxis = equalError(rows, "axis_aligned").filter((f) => f.method === "sheared" && f.spp === 9);
  const sheared = at(rows, "sheared", 9);
  return [
    ["sheared, 9 spp: average's RMSE over its", timesLower(pairs(rows, "sheared", "average", 9)), ">=", 5, "times"],
    ["sheared, 9 spp: axis-aligned's RMSE over its", timesLower(pairs(rows, "sheared", "axis_aligned", 9)), ">=", 1.8, "times"],
    ["sheared, 9 spp: average's samples for equal error", factors.map((f) => f.samples), ">=", 12, "times"],
    ["sheared, 9 spp: average's CPU time for equal error", factors.map((f) => f.seconds), ">=", 8, "times"],
    ["  the same, were the filter free", factors.map((f) => f.free), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's samples for equal error", toAxis.map((f) => f.samples), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's CPU time for equal error", toAxis.map((f) => f.seconds), ">=", null, "times"],
    ["sheared, 9 spp: filter's CPU time per megapixel", sheared.map(secondsPerMegapixel), "<=", 0.25, "s"],
    ["sheared, 9 spp: filter's share of the frame's CPU time", sheared.map((r) => filterSeconds(r) / r.cpu_s.total), "<=", 0.2, "ratio"],
    // A third of what the sheared filter may take; were it of what that takes, a faster one would miss it.
    ["axis-aligned, 9 spp: filter's CPU time per megapixel", at(rows, "axis_aligned", 9).map(secondsPerMegapixel), "<=", 0.25 / 3, "s"],
    ["axis-aligned, 9 spp: its CPU time over sheared's", pairs(rows, "axis_aligned", "sheared", 9).map(([a, s]) =>
      filterSeconds(a) / filterSeconds(s)), "<=", null, "ratio"],
    monotone(rows, "sheared")];
}

// Of adaptive rays at a mu: its error over that of another method with as many rays everywhere.
const overUniform = (rows, mu, other) => rows.filter((r) => r.method === "adaptive" && r.mu === mu)
  .map((r) => r.judged.rmse / errorAt(curve(rows, r.scene, other, (o) => o.spp), r.spp));
function turned(rows) {
  const scenes = [...new Set(rows.filter((r) => r.mu).map((r) => r.scene))];
  const errors = (scene) => rows.filter((r) => r.scene === scene && r.mu).sort((a, b) => a.mu - b.mu).map((r) => r.judged.rmse);
  // Below mu 1 next to no rays are added: steps that small are noise.
  return ["adaptive: scenes whose error falls with mu as rays are added",
    scenes.length > 0 ? [scenes.filter((s) => errors(s).every((y, i, all) => i === 0 || y <= all[i - 1])).length] : [], ">=", null, "scenes"];
}

function indirect(rows) {
  const factors = equalError(rows, "average").filter((f) => f.method === "constant" && f.spp === 16);
  const of = (scene, what) => factors.filter((f) => f.scene === scene).map((f) => f[what]);
  const auto = rows.filter((r) => r.method === "auto");
  return [
    ["constant, 16 spp, box: average's RMSE over its", timesLower(pairs(rows, "constant", "average", 16).filter(([r]) => r.scene === "box")), ">=", 10, "times"],
    ["  the same over all scenes", timesLower(pairs(rows, "constant", "average", 16)), ">=", null, "times"],
    ["constant, 16 spp, box: average's samples for equal error", of("box", "samples"), ">=", 25, "times"],
    ["constant, 16 spp, living room: the same", of("living_room", "samples"), ">=", 8, "times"],
    ["  the same over all scenes", factors.map((f) => f.samples), ">=", null, "times"],
    ["constant, 16 spp, box: average's CPU time for equal error", of("box", "seconds"), ">=", 10, "times"],
    ["constant, 16 spp, living room: the same", of("living_room", "seconds"), ">=", 5, "times"],
    ["  the same over all scenes", factors.map((f) => f.seconds), ">=", null, "times"],
    ["sheared, 16 spp, reflector: constant's RMSE over its", timesLower(pairs(rows, "sheared", "constant", 16).filter(([r]) => r.scene === "reflector")), ">=", null, "times"],
    ["sheared, 16 spp: its CPU time over constant's", pairs(rows, "sheared", "constant", 16).map(([s, c]) =>
      filterSeconds(s) / filterSeconds(c)), "<=", null, "times"],
    ["adaptive, mu 1: rays a pixel", rows.filter((r) => r.mu === 1).map((r) => r.spp), "<=", null, "rays"],
    ["adaptive, mu 1: its RMSE over constant's with as many rays", overUniform(rows, 1, "constant"), "<=", null, "times"],
    ["adaptive, mu 2: its RMSE over linear's with as many rays", overUniform(rows, 2, "linear"), "<=", null, "times"],
    turned(rows),
    ["constant, 16 spp: filter's CPU time per megapixel", at(rows, "constant", 16).map(secondsPerMegapixel), "<=", 0.12, "s"],
    ["auto, every scene: picture's energy off the path tracer's", worst(auto.map((r) => Math.abs(r.beauty.energy - 1))), "<=", 0.005, "ratio"],
    ["auto, every scene: indirect light's bias", worst(auto.map((r) => Math.abs(r.judged.bias))), "<=", null, "ratio"],
    monotone(rows, "auto"),
    beyondDoubt(rows, "auto")];
}

function lens(rows) {
  const factors = (part) => equalError(rows, "average", part).filter((f) => f.method === "sheared" && f.spp === 9);
  const toAxis = equalError(rows, "axis_aligned").filter((f) => f.method === "sheared" && f.spp === 9);
  const all = factors("judged"), nine = at(rows, "sheared", 9);
  return [
    ["sheared, 9 spp: average's RMSE over its", timesLower(pairs(rows, "sheared", "average", 9)), ">=", 2.2, "times"],
    ["  the same away from silhouettes", pairs(rows, "sheared", "average", 9).map(([r, p]) => p.away.rmse / r.away.rmse), ">=", null, "times"],
    ["extra, 9 spp and 9 more: average of 9's RMSE over its", timesLower(pairs(rows, "extra", "average", 9)), ">=", 3, "times"],
    ["  sheared's of 16 over its", at(rows, "extra", 9).map((r) => [r, at(rows, "sheared", 16).find((o) => o.scene === r.scene)])
      .filter(([, o]) => o).map(([r, o]) => o.judged.rmse / r.judged.rmse), ">=", null, "times"],
    ["sheared, 9 spp: plain paths' RMSE over its", timesLower(pairs(rows, "sheared", "paths", 9)), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's RMSE over its", timesLower(pairs(rows, "sheared", "axis_aligned", 9)), ">=", null, "times"],
    ["sheared, 9 spp: average's samples for equal error", all.map((f) => f.samples), ">=", 4, "times"],
    ["  the same away from silhouettes", factors("away").map((f) => f.samples), ">=", 8, "times"],
    ["sheared, 9 spp: average's CPU time for equal error", all.map((f) => f.seconds), ">=", null, "times"],
    ["sheared, 9 spp: axis-aligned's samples for equal error", toAxis.map((f) => f.samples), ">=", null, "times"],
    ["sheared, 9 spp, AVX2: filter's CPU time per megapixel", secondsWith(nine, "avx2"), "<=", 0.4, "s"],
    ["  the same of the dearest scene", worst(secondsWith(nine, "avx2")), "<=", null, "s"],
    ["  the same with the best that the machine has", nine.map(secondsPerMegapixel), "<=", null, "s"],
    monotone(rows, "sheared")];
}

function combined(rows) {
  const factors = equalError(rows, "average").filter((f) => f.method === "auto" && f.spp === 9);
  const toPaths = equalError(rows, "paths").filter((f) => f.method === "auto" && f.spp === 9);
  const nine = at(rows, "auto", 9), all = pairs(rows, "auto", "average", 9);
  const inPart = (part) => all.map(([r, p]) => p[part].rmse / r[part].rmse);
  return [
    ["auto, 9 spp: average's CPU time for equal error", factors.map((f) => f.seconds), ">=", 5, "times"],
    ["  the same, were the filters free", factors.map((f) => f.free), ">=", null, "times"],
    ["auto, 9 spp: average's samples for equal error", factors.map((f) => f.samples), ">=", null, "times"],
    ["auto, 9 spp: plain paths' CPU time for equal error", toPaths.map((f) => f.seconds), ">=", null, "times"],
    ["auto, 9 spp: average's RMSE over its", timesLower(all), ">=", null, "times"],
    ["  the same away from silhouettes", inPart("away"), ">=", null, "times"],
    ["  the same at silhouettes out of focus", inPart("edges"), ">=", null, "times"],
    ["auto, 9 spp: filters' CPU time per megapixel", nine.map(secondsPerMegapixel), "<=", null, "s"],
    ["  of which light at lens samples", nine.map((r) => r.cpu_s.lens_relight / r.megapixels), "<=", null, "s"],
    ["auto, every scene, 9 spp: energy off the path tracer's", worst(nine.map((r) => Math.abs(r.beauty.energy - 1))), "<=", 0.005, "ratio"],
    ["average, every scene, 9 spp: the same", worst(at(rows, "average", 9).map((r) => Math.abs(r.beauty.energy - 1))), "<=", null, "ratio"],
    ["auto, every scene, 9 spp: energy at silhouettes off the path tracer's", worst(nine.map((r) => Math.abs(r.edges.bias))), "<=", null, "ratio"],
    monotone(rows, "auto", 64)];
}

const FIGURES = { shadows, indirect, lens, combined };

function judge(line) {
  const b = Array.isArray(line)
    ? (([figure, values, relation, bound, unit]) => ({ figure, values, relation, bound, unit }))(line) : line;
  const values = b.values.filter(Number.isFinite);
  if (values.length === 0) return b.bound === null ? null : { figure: b.figure, value: null, relation: b.relation,
    bound: b.bound, unit: b.unit, least: null, most: null, scenes: 0, ok: null };
  const value = median(values);
  return { figure: b.figure, value, relation: b.relation, bound: b.bound, unit: b.unit,
    least: Math.min(...values), most: Math.max(...values), scenes: b.scenes ?? values.length,
    ok: b.bound === null || (b.relation === ">=" ? value >= b.bound : value <= b.bound) };
}

export const bounds = (rows) => Object.entries(FIGURES).flatMap(([effect, figures]) =>
  figures(rows.filter((r) => r.effect === effect)).map(judge).filter(Boolean).map((b) => ({ effect, ...b })));

const verdict = (b) => (b.ok === null ? "NOT MEASURED" : b.ok ? "reached" : "MISSED");

// A line for people.
export const sentence = (b) => `${b.figure.padEnd(58)} ${(b.value?.toPrecision(3) ?? "none").padStart(10)} ${b.unit.padEnd(12)} ` +
  (b.bound === null ? "" : `(bound ${b.relation} ${Number(b.bound.toPrecision(3))}) ${verdict(b)}`);

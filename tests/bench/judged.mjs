// What the lines amount to, for the report and for RESULTS.md: which rows are looked at, the bounds, the costs.
import { bounds } from "./accuracy/bounds.mjs";
import { effects } from "./accuracy/effects.mjs";
import { equalError, filterSeconds, median } from "./accuracy/factors.mjs";
import { SEED } from "./accuracy/measure.mjs";

// Bounds speak of pictures this large: widths of filters, and so what they gain, are counted in pixels.
export const JUDGED_SIDE_PX = 512;

const isQuoted = (r) => r.spp === effects[r.effect].at || r.mu === 1;
export const quoted = (rows) => rows.filter(isQuoted);

// Rows of pictures, each scene at its largest side, with the seed that all share.
export function rowsOf(lines) {
  const rows = lines.filter((l) => l.part === "accuracy" && l.seed === SEED), side = new Map();
  for (const r of rows) side.set(r.scene, Math.max(side.get(r.scene) ?? 0, r.side_px));
  return rows.filter((r) => r.side_px === side.get(r.scene));
}

export const sidesOf = (rows) => [...new Set(rows.map((r) => r.side_px))].sort((a, b) => a - b);

// Figures with their bounds, as bounds.mjs has them; judged: whether the pictures are large enough, and all
// of the effect's scenes are there, for the bound to be about them.
export function effectBounds(rows, allScenes) {
  const asked = new Set(rows.map((r) => r.effect));
  const large = (effect) => rows.every((r) => r.effect !== effect || r.side_px >= JUDGED_SIDE_PX) &&
    allScenes.filter((s) => s.effect === effect).every((s) => rows.some((r) => r.scene === s.name));
  // Figures that begin with blanks are about the one before.
  let before = "";
  return bounds(rows).filter((b) => asked.has(b.effect) && b.value !== null).map((b) => {
    if (!b.figure.startsWith(" ")) before = b.figure;
    return { ...b, figure: b.figure.trim(), of: b.figure.startsWith(" ") ? before : null, judged: b.bound !== null && large(b.effect) };
  });
}

const QUOTED_METHOD = { shadows: "sheared", indirect: "constant", lens: "sheared", combined: "auto" };
const spread = (values) => values.length === 0 ? null : { value: median(values), least: Math.min(...values), most: Math.max(...values), scenes: values.length };

// The headlines, effect by effect: what filtering gains at the count that is quoted.
export function headlines(rows) {
  return Object.values(effects).filter((e) => rows.some((r) => r.effect === e.name)).map((e) => {
    const mine = rows.filter((r) => r.effect === e.name), method = QUOTED_METHOD[e.name], here = mine.filter((r) => r.method === method && r.spp === e.at);
    const factors = equalError(mine, "average").filter((f) => f.method === method && f.spp === e.at);
    const average = (r) => mine.find((o) => o.scene === r.scene && o.method === "average" && o.spp === r.spp);
    return { effect: e, method, rmse: spread(here.filter(average).map((r) => average(r).judged.rmse / r.judged.rmse)),
      samples: spread(factors.map((f) => f.samples)), seconds: spread(factors.map((f) => f.seconds)), extrapolated: factors.some((f) => f.extrapolated),
      share: spread(here.map((r) => filterSeconds(r) / r.cpu_s.judged)) };
  });
}

export const ofPart = (lines, part) => lines.filter((l) => l.part === part);

// Wall time with each number of workers beside the fewest: {workers, wall_s, speedup}.
export function scaling(lines) {
  const farms = ofPart(lines, "workers").sort((a, b) => a.workers - b.workers), first = farms[0];
  return farms.map((l) => ({ ...l, wall_s: l.wall.total, speedup: first.workers * first.wall.total / l.wall.total }));
}

export const pixelBytes = (l) => l.bytes_received / (1e6 * l.megapixels);

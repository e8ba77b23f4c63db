// What pictures of real scenes must reach.

// psnr_db of auto, at least, by samples a pixel.
const PSNR_DB = {
  cornell: { 4: 48, 16: 52, 64: 55 }, blocks: { 4: 42, 16: 47 }, blocks_sky: { 4: 43, 16: 47 }, spheres_venice: { 4: 33, 16: 38 },
  helmet_park: { 4: 36, 16: 40 }, helmet_studio: { 4: 32, 16: 36 }, veach_mis: { 4: 30, 16: 35 }, living_room: { 4: 20, 16: 25 } };
const TRACE_OVER_NONE = 1.25, FILTERS_S = 0.4;
// With fewer samples than that a frame's own cost is most of what is measured.
const COST_FROM_SPP = 4;

const figure = (row, what, value, relation, bound, unit) => ({ scene: row.scene, spp: row.spp, figure: `${row.scene}, ${row.spp} spp: ${what}`, value,
  relation, bound, unit, ok: relation === ">=" ? value === null || value >= bound : value <= bound });

// Of one picture by auto. A value of null is one that the references' noise hides, which no bound asks for.
function boundsOf(row) {
  const least = PSNR_DB[row.scene]?.[row.spp], found = [];
  if (least !== undefined) found.push(figure(row, "psnr_db of auto", row.psnr_db, ">=", least, "dB"));
  if (row.spp < COST_FROM_SPP) return found;
  if (row.trace_over_none) found.push(figure(row, "tracing of auto over that of none", row.trace_over_none, "<=", TRACE_OVER_NONE, "times"));
  found.push(figure(row, "filters' CPU time per megapixel", row.filters_s_per_megapixel, "<=", FILTERS_S, "s"));
  return found;
}

// rows: lines of the part. [{scene, spp, figure, value, relation, bound, unit, ok}]
export const realBounds = (rows) => rows.filter((r) => r.method === "auto").flatMap(boundsOf);

// A line for people.
export const realSentence = (b) => `${b.figure.padEnd(58)} ${(b.value === null ? "hidden" : b.value.toPrecision(4)).padStart(10)} ${b.unit.padEnd(6)} (bound ${b.relation} ${b.bound}) ${b.ok ? "holds" : "MISSED"}`;

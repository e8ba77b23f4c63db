// A job's plan and statistics as rows for people: [[name, value], ...], only what is known.

const count = (n) => n >= 1e6 ? `${(n / 1e6).toFixed(1)} million` : String(n);
const size = (bytes) => bytes >= 1e9 ? `${(bytes / 1e9).toFixed(2)} GB` : `${(bytes / 1e6).toFixed(1)} MB`;
const words = (name) => name.replaceAll("_", " ");
const entries = (object, show = count) =>
  Object.entries(object ?? {}).filter(([, value]) => value > 0)
    .map(([name, value]) => `${words(name)} ${show(value)}`).join(", ");

const INTEGRATORS = { paths: "path tracing", light_field: "light fields",
  paths_and_light_field: "path tracing and light fields", lens_field: "light field of the lens" };
const filter = (name, why) => name && (why ? `${words(name)}: ${why}` : words(name));
const known = (rows) => rows.filter(([, value]) => value);

function cameraText({ name, type, yfov_deg: yfov, aperture_radius: radius, focus_distance: focus, made_by_importer: made }) {
  return [name || (made ? "made by the importer" : "eye and target"), type, yfov && `${yfov.toFixed(1)}° high`,
    radius && `aperture ${Number(radius.toPrecision(4))}, focus at ${Number(focus.toPrecision(4))}`].filter(Boolean).join(", ");
}

const lightText = ({ type, from, index, name, samples }) =>
  `${type}${name ? ` “${name}”` : ""} of the ${from === "job" ? `job (/lights/${index})` : "scene"}${samples ? `, ${samples} ${samples === 1 ? "sample" : "samples"}` : ""}`;

// "rectangle: sheared, other lobes halves"
function lightFiltersText(rows) {
  const lights = [...new Set((rows ?? []).map(({ light }) => light))];
  return lights.map((light) => {
    const [first, second] = rows.filter((row) => row.light === light).map(({ filter: name }) => words(name));
    return `${light}: ${first}${second && second !== first ? `, other lobes ${second}` : ""}`;
  }).join("; ");
}

export function documentRows(document) {
  const { image, sampling } = document ?? {};
  return known([
    ["Image", image && `${image.width} × ${image.height}`],
    ["Samples", sampling && `${sampling.spp} per pixel, seed ${sampling.seed}`],
  ]);
}

export function planRows(plan) {
  if (!plan) return [];
  const { tiles, environment } = plan;
  return known([
    ["Integrator", INTEGRATORS[plan.integrator]],
    ["Camera", plan.camera && cameraText(plan.camera)],
    ["Lights", (plan.lights ?? []).map(lightText).join("; ") || "none"],
    ["Environment", environment && (environment.type === "map" ? "a map" : "constant")],
    ["Effects", (plan.effects ?? []).map(words).join(", ")],
    ["Rays per pixel", entries(plan.samples)],
    ["Tiles", tiles && `${tiles.count} of ${tiles.side_px} px`],
    ["Light cleaned by", lightFiltersText(plan.light_filters)],
    ["Shadow filter", filter(plan.filter, plan.filter_why)],
    ["Indirect filter", filter(plan.indirect_filter, plan.indirect_filter_why)],
    ["Glossy filter", filter(plan.glossy_filter, plan.glossy_filter_why)],
    ["Lens filter", filter(plan.lens_filter, plan.lens_filter_why)],
    ["Filter of paths", filter(plan.residual_filter, plan.residual_filter_why)],
    ["Frames on each side", plan.temporal_why && filter(String(plan.temporal), plan.temporal_why)],
    ["Light through the lens", plan.lens_relight_why && filter(plan.lens_relight, plan.lens_relight_why)],
  ]);
}

export const skippedRows = (plan) => (plan?.skipped ?? []).map(({ what, why }) => [what, why]);

export function statisticsRows(statistics) {
  if (!statistics) return [];
  const { tiles, results } = statistics;
  return known([
    ["Not traced", entries(statistics.skipped)],
    ["Wall time", statistics.wall_s && `${statistics.wall_s.toFixed(2)} s`],
    ["CPU time", statistics.cpu_s?.total && `${statistics.cpu_s.total.toFixed(2)} s`],
    ["Tiles", tiles && `${tiles.done} done, ${tiles.reissued} reissued`],
    ["Rejected results", results && (results.dropped || results.corrupt) && `${results.dropped} late or duplicate, ${results.corrupt} damaged`],
    ["Received", statistics.bytes_received && size(statistics.bytes_received)],
    ["Peak memory", entries(statistics.peak_rss_bytes, size)],
  ]);
}

// [[stage, seconds], ...], the longest first; without their sum.
export const stageTimes = (statistics) => Object.entries(statistics?.cpu_s ?? {})
  .filter(([name, value]) => name !== "total" && value > 0).map(([name, value]) => [words(name), value]).sort((a, b) => b[1] - a[1]);
export const rayCounts = (statistics) => Object.entries(statistics?.rays ?? {})
  .filter(([, value]) => value > 0).map(([name, value]) => [words(name), value]).sort((a, b) => b[1] - a[1]);

// A job's plan and statistics as rows for people.

const count = (n) => n >= 1e6 ? `${(n / 1e6).toFixed(1)} million` : String(n);
const size = (bytes) => bytes >= 1e9 ? `${(bytes / 1e9).toFixed(2)} GB` : `${(bytes / 1e6).toFixed(1)} MB`;
const entries = (object, show = count) =>
  Object.entries(object ?? {}).filter(([, value]) => value > 0)
    .map(([name, value]) => `${name.replaceAll("_", " ")} ${show(value)}`).join(", ");

const INTEGRATORS = { paths: "path tracing", light_field: "light fields",
  paths_and_light_field: "path tracing and light fields" };
const filter = (name, why) => name && `${name.replaceAll("_", " ")}: ${why}`;

// [[name, value], ...]; only what the job says.
export function facts(job) {
  const rows = [];
  const add = (name, value) => { if (value) rows.push([name, value]); };
  const document = job.document ?? {};
  const plan = job.plan ?? {};
  const statistics = job.statistics ?? {};
  if (document.image) add("Image", `${document.image.width} × ${document.image.height}`);
  if (document.sampling) add("Samples", `${document.sampling.spp} a pixel, seed ${document.sampling.seed}`);
  add("Integrator", INTEGRATORS[plan.integrator]);
  add("Shadow filter", filter(plan.filter, plan.filter_why));
  add("Indirect filter", filter(plan.indirect_filter, plan.indirect_filter_why));
  add("Glossy filter", filter(plan.glossy_filter, plan.glossy_filter_why));
  if (Array.isArray(plan.effects)) add("Effects", plan.effects.join(", "));
  for (const { what, why } of plan.skipped ?? []) add("Skipped", `${what}: ${why}`);
  add("Rays", entries(statistics.rays));
  add("Not traced", entries(statistics.skipped));
  add("CPU time", entries(statistics.cpu_s, (s) => `${s.toFixed(2)} s`));
  if (statistics.wall_s) add("Wall time", `${statistics.wall_s.toFixed(2)} s`);
  if (statistics.bytes_received) add("Received", size(statistics.bytes_received));
  add("Peak memory", entries(statistics.peak_rss_bytes, size));
  return rows;
}

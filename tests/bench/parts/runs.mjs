// What several runs of one job amount to.

export const median = (values) => {
  const sorted = values.slice().sort((a, b) => a - b), n = sorted.length;
  return n % 2 ? sorted[(n - 1) / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
};

const over = (find) => (list) => Object.fromEntries(Object.keys(list[0]).map((name) => [name, find(list.map((one) => one[name]))]));
const medians = over(median), leasts = over((values) => Math.min(...values));

// Medians of times, and of CPU times the least, which other work moves least; counts and bytes, which are the same every time, of the first run.
export function summary(runs) {
  const { rays, skipped, shadow, indirect, glossy, lens, pixels, peak_rss_bytes } = runs[0].statistics;
  return { runs: runs.length, cpu_s: medians(runs.map((r) => r.statistics.cpu_s)), cpu_min_s: leasts(runs.map((r) => r.statistics.cpu_s)), wall: medians(runs.map((r) => r.wall)), rays, skipped,
    filters: { shadow, indirect, glossy, lens }, pixels, bytes_received: runs[0].statistics.bytes_received, link: runs[0].link,
    peak_rss_bytes: { server: Math.max(peak_rss_bytes.server, ...runs.map((r) => r.statistics.peak_rss_bytes.server)),
      worker: Math.max(peak_rss_bytes.worker, ...runs.map((r) => r.statistics.peak_rss_bytes.worker)) } };
}

export async function repeated(farm, job, times) {
  const runs = [];
  for (let i = 0; i < times; i++) runs.push(await farm.run(job));
  return summary(runs);
}

export const raysOf = (rays) => Object.entries(rays).reduce((sum, [kind, n]) => sum + (kind === "paths" || kind === "lens" ? 0 : n), 0);

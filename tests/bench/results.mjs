// RESULTS.md: a short page of what was measured, made from results.jsonl, the figures of one run; and the part
// of README.md that is cut from it. A test makes both again and compares.
//   results.mjs check: status 1 when either is not what results.jsonl gives
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { effects } from "./accuracy/effects.mjs";
import { effectBounds, headlines, JUDGED_SIDE_PX, ofPart, pixelBytes, rowsOf, scaling, sidesOf } from "./judged.mjs";
import { scenes } from "./scenes/scenes.mjs";

const ROOT = new URL("../..", import.meta.url).pathname, FIGURES = `${ROOT}tests/bench/results.jsonl`, PAGE = `${ROOT}tests/bench/RESULTS.md`, README = `${ROOT}README.md`;
const BEGIN = "<!-- figures: from tests/bench/RESULTS.md -->", END = "<!-- /figures -->";

const three = (v) => v === null || v === undefined ? null : Number(v.toPrecision(3));
const rounded = (s) => s && { value: three(s.value), least: three(s.least), most: three(s.most), scenes: s.scenes };

// Real scenes may be measured by themselves: all else takes hours.
const isReal = (f) => f.is === "real" || f.is === "real_run" || f.from === "real";

// What of a run's lines is kept in the repository; of what it has not measured, what was kept before.
export function figuresOf(lines, before = []) {
  const now = measured(lines), effects = rowsOf(lines).length > 0, real = ofPart(lines, "real").length > 0;
  return [...(effects || before.length === 0 ? now : before).filter((f) => !isReal(f)), ...(real ? now : before).filter(isReal)];
}

function measured(lines) {
  const rows = rowsOf(lines), machine = lines.find((l) => l.part === "machine");
  const about = (effect) => { const mine = rows.filter((r) => r.effect === effect), seen = new Set(mine.map((r) => r.scene)); return { effect, scenes: seen.size, sides_px: sidesOf(mine), pictures: mine.length,
    left_out: scenes.filter((s) => s.effect === effect && !seen.has(s.name)).map((s) => s.name), poor: [...new Set(mine.filter((r) => !r.reference.good).map((r) => r.scene))] }; };
  const ratio = (a, b) => a > 0 ? three(1 - b / a) : null;
  const by = { build: machine.build, day: lines.map((l) => l.time).sort().at(-1).slice(0, 10), cpu: machine.cpu, cores: machine.cores, instructions: machine.instructions };
  return [
    { is: "real_run", ...by },
    { is: "run", ...by,
      memory_gb: three(machine.memory_bytes / 1e9), load: three(machine.load_before), effects: [...new Set(rows.map((r) => r.effect))].map(about) },
    ...headlines(rows).map((h) => ({ is: "headline", effect: h.effect.name, method: h.method, rmse: rounded(h.rmse), samples: rounded(h.samples), seconds: rounded(h.seconds), share: rounded(h.share), extrapolated: h.extrapolated })),
    ...effectBounds(rows, scenes).filter((b) => b.bound !== null).map((b) => ({ is: "bound", effect: b.effect, figure: b.figure, of: b.of, ...rounded(b), relation: b.relation, bound: three(b.bound), unit: b.unit, judged: b.judged, ok: b.ok })),
    ...ofPart(lines, "figure").map((l) => ({ is: "rate", from: l.from, figure: l.figure, value: l.value, bound: l.bound, unit: l.unit, ok: l.ok })),
    ...scaling(lines).map((l) => ({ is: "workers", workers: l.workers, height: l.height_px, wall_s: three(l.wall_s), speedup: three(l.speedup), after_last_tile: three(l.wall.after_last_tile / l.wall.frame) })),
    ...ofPart(lines, "resolution").map((l) => ({ is: "resolution", kind: l.kind, about: l.about, width: l.width, height: l.height, cpu_s: three(l.cpu_s.total), us_a_pixel: three(l.cpu_s.total / l.megapixels),
      bytes_a_pixel: three(pixelBytes(l)), after_last_tile: three(l.wall.after_last_tile / l.wall.frame), server_mb: three(l.peak_rss_bytes.server / 1e6), worker_mb: three(l.peak_rss_bytes.worker / 1e6) })),
    ...ofPart(lines, "triangles").map((l) => ({ is: "triangles", triangles: l.triangles, side_px: l.side_px, import_s: three(l.cpu_s.import), build_s: three(l.cpu_s.build), trace_s: three(l.cpu_s.trace), worker_mb: three(l.peak_rss_bytes.worker / 1e6),
      ...(l.apart ? { apart_build_s: three(l.apart.cpu_s.build), apart_wall: three(l.apart.wall.total / l.wall.total), apart_cpu: three(l.apart.cpu_s.total / l.cpu_s.total), apart_mb: three(l.apart.workers * l.apart.peak_rss_bytes.worker / 1e6) } : {}) })),
    ...ofPart(lines, "links").map((l) => ({ is: "link", kind: l.kind, link: l.link_kind, width: l.width, height: l.height, bytes: l.link.received_bytes + l.link.sent_bytes, cpu: three(l.over_unix.cpu), loop: three(l.over_unix.coordinate) })),
    ...ofPart(lines, "real").map((l) => ({ is: "real", scene: l.scene, method: l.method, spp: l.spp, psnr_db: three(l.psnr_db), rmse01: three(l.rmse01), relmse999: three(l.relmse999), flip: three(l.flip),
      ...(l.paths === "older" ? { paths: l.paths } : {}), ...(l.denoiser_s ? { denoiser_s: three(l.denoiser_s), picture_s: three(l.picture_s) } : {}),
      ...(l.runs ? { trace_over_none: three(l.trace_over_none), filters_s_per_megapixel: three(l.filters_s_per_megapixel), trace_s: three(l.cpu_min_s.trace), cpu_s: three(l.cpu_min_s.total) } : {}) })),
    ...ofPart(lines, "skips").map((l) => ({ is: "skip", skip: l.skip, name: l.name, about: l.about, side_px: l.side_px, rays: ratio(l.need.rays, l.spare.rays), bytes: ratio(l.need.bytes, l.spare.bytes), cpu: ratio(l.need.cpu_s, l.spare.cpu_s), holds: l.holds }))];
}

const table = (head, rows) => rows.length === 0 ? "" : `| ${head.join(" | ")} |\n|${head.map((h, i) => i === 0 ? "---" : "---:").join("|")}|\n${rows.map((r) => `| ${r.join(" | ")} |`).join("\n")}\n`;
const span = (s, unit = "") => !s ? "–" : s.least < s.most ? `${s.value}${unit} (${s.least}–${s.most})` : `${s.value}${unit}`;
const share = (v) => v === null ? "–" : `${v < 0 ? "−" : ""}${Number((100 * Math.abs(v)).toPrecision(2))} %`;
const verdict = (b) => b.judged === false ? "not judged" : b.ok ? "holds" : "**missed**";
const of = (figures, is) => figures.filter((f) => f.is === is);
const title = (name) => effects[name]?.title ?? name;
const bound = (b) => `${b.relation === ">=" ? "≥" : "≤"} ${b.bound}`;

function what(run) {
  const names = (list) => list.length > 0 ? list.join(", ") : "–";
  const rows = run.effects.map((e) => [title(e.effect), e.scenes, names(e.left_out), e.pictures, e.sides_px.join(", "), names(e.poor)]);
  return `Build \`${run.build}\`, ${run.day}, on ${run.cpu} with ${run.cores} cores (${run.instructions}), ${run.memory_gb} GB; ${run.load} processes a core wanted to run in the minute before.

${table(["effect", "scenes", "not measured", "pictures", "side, px", "references not good enough"], rows)}`;
}

// Of which pictures an effect's figures are: their side, and how many of its scenes if not all.
function extent(figures, effect) {
  const { scenes: seen, left_out, sides_px } = of(figures, "run")[0].effects.find((e) => e.effect === effect);
  return `${sides_px.join(" and ")} px${left_out.length > 0 ? `, ${seen} of ${seen + left_out.length} scenes` : ""}`;
}

const headlineTable = (figures) => table(["effect (filter, samples per pixel; picture)", "error: average ÷ filtered", "samples for equal error: average ÷ filtered", "CPU time for equal error: average ÷ filtered", "filters' share of CPU time"],
  of(figures, "headline").map((h) => [`${title(h.effect)} (${h.method}, ${effects[h.effect].at}; ${extent(figures, h.effect)})`, span(h.rmse, "×"), `${span(h.samples, "×")}${h.extrapolated ? " *" : ""}`, span(h.seconds, "×"), h.share ? share(h.share.value) : "–"]));

// Rates of the machinery; the others compare filters with brute force.
const SHORT = ["rays", "paths", "share", "tile", "memory"];
const signs = (bound) => bound.replace(">=", "≥").replace("<=", "≤");
const isBeside = (r) => !SHORT.includes(r.from) && r.from !== "real";
const rateTable = (figures, wanted = () => true) => table(["figure", "measured", "bound", ""], of(figures, "rate").filter(wanted).map((r) => [r.figure, `${Number(r.value.toPrecision(3))} ${r.unit}`, signs(r.bound), verdict(r)]));

function costs(figures) {
  const workers = of(figures, "workers"), sizes = of(figures, "resolution"), hills = of(figures, "triangles"), parts = [];
  if (workers.length > 0) parts.push(`Wall time with workers of one thread, ${workers[0].height} lines:\n\n${table(["workers", "wall s", "speed-up", "after the last tile"], workers.map((w) => [w.workers, w.wall_s, `${w.speedup}×`, share(w.after_last_tile)]))}`);
  if (sizes.length > 0) parts.push(`Against resolution, the Cornell box at 9 samples (${[...new Set(sizes.map((s) => `${s.kind}: ${s.about}`))].join("; ")}):\n\n${table(["picture", "CPU s", "CPU µs a pixel", "bytes a pixel", "after the last tile", "coordinator, MB", "worker, MB"],
    sizes.map((s) => [`${s.kind}, ${s.width}×${s.height}`, s.cpu_s, s.us_a_pixel, s.bytes_a_pixel, share(s.after_last_tile), s.server_mb, s.worker_mb]))}`);
  if (hills.length > 0) parts.push(`Against triangles, ${hills[0].side_px}×${hills[0].side_px} pixels (CPU seconds; import once a scene, BVH once a worker; apart: workers of one thread, one a core, in place of one of all cores):\n\n${table(["triangles", "import", "BVH", "trace", "worker, MB", "apart: BVH", "apart: MB", "apart: CPU", "apart: wall"],
    hills.map((h) => [h.triangles, h.import_s, h.build_s, h.trace_s, h.worker_mb, h.apart_build_s ?? "", h.apart_mb ?? "", h.apart_cpu ? `${h.apart_cpu}×` : "", h.apart_wall ? `${h.apart_wall}×` : ""]))}`);
  const links = of(figures, "link");
  if (links.length > 0) parts.push(`Links of local workers, ${links[0].width}×${links[0].height} (CPU time over that of a Unix socket's frames; loop: the coordinator's, which reads and writes links):\n\n${table(["picture", "link", "MB", "CPU", "loop"], links.map((l) => [l.kind, l.link, three(l.bytes / 1e6), `${l.cpu}×`, `${l.loop}×`]))}`);
  return parts.join("\n");
}

// Decibels by scene and count, each method in a column of its own.
function realScenes(figures) {
  const rows = of(figures, "real"), judged = of(figures, "rate").filter((r) => r.from === "real"), steps = [...new Set(rows.map((r) => `${r.scene}, ${r.spp}`))];
  if (rows.length === 0) return "";
  const known = (step) => rows.filter((r) => `${r.scene}, ${r.spp}` === step), said = (v) => v === undefined ? "–" : v === null ? "hidden" : v;
  const held = (step, unit) => judged.filter((r) => r.figure.startsWith(`${step} spp: `) && r.unit === unit).map((r) => `${signs(r.bound)}: ${verdict(r)}`)[0] ?? "";
  const [by] = of(figures, "real_run");
  return `Build \`${by.build}\`, ${by.day}, on ${by.cpu} with ${by.cores} cores (${by.instructions}). PSNR in dB as a screen shows the picture, the noise of the references taken out ("hidden": below what that lets one tell); OIDN: Intel Open Image Denoise on ${rows.some((r) => r.paths === "older") ? "as many paths of an older build" : "the same paths"}.

${table(["scene, samples", "none", "auto", "OIDN", "bound on auto", "tracing of auto over that of none", "", "filters, CPU s a megapixel", ""], steps.map((step) => {
    const here = known(step), of = (method, what) => said(here.find((r) => r.method === method)?.[what]);
    return [step, of("none", "psnr_db"), of("auto", "psnr_db"), of("oidn", "psnr_db"), held(step, "dB"), of("auto", "trace_over_none"), held(step, "times"), of("auto", "filters_s_per_megapixel"), held(step, "s")];
  }))}`;
}

function limits(figures) {
  const judged = of(figures, "bound").some((b) => !b.judged), extrapolated = of(figures, "headline").some((h) => h.extrapolated);
  return [`- CPU seconds are those of one shared machine: ratios of this run are what to quote. Medians over scenes, the least and the largest in brackets.`,
    ...(judged ? [`- Bounds of accuracy are about all scenes at ${JUDGED_SIDE_PX} px and more; "not judged" are those of smaller pictures, on which filters are narrower and gain less.`] : []),
    ...(extrapolated ? ["- \\* in some scene beyond the largest count that the average was measured at: extrapolated along its last leg."] : []),
    "- Errors are against converged pictures of this renderer itself; that it agrees with others' is shown by `make golden`."].join("\n");
}

// Returns what README shows: the table of effects and one sentence.
export function excerpt(figures) {
  const [run] = of(figures, "run"), bounds = [...of(figures, "bound").filter((b) => b.judged), ...of(figures, "rate")], missed = bounds.filter((b) => !b.ok);
  const skips = of(figures, "skip");
  const verdicts = bounds.length === 0 ? "No bound was judged by this run" : missed.length === 0 ? `All ${bounds.length} bounds that were judged hold` : `${missed.length} of ${bounds.length} bounds that were judged are missed`;
  return `Medians over scenes (least–largest), errors against converged references${of(figures, "headline").some((h) => h.extrapolated) ? ", \\* extrapolated" : ""}; build \`${run.build}\` on ${run.cpu}, ${run.cores} cores, ${run.instructions}. ` +
    `${verdicts}; ${skips.filter((s) => s.holds).length} of ${skips.length} pairs of frames show that work which is not needed is skipped.\n\n${headlineTable(figures).trimEnd()}`;
}

export function page(figures) {
  const [run] = of(figures, "run"), bounds = of(figures, "bound"), skips = of(figures, "skip");
  return [`# Results

Made by \`make bench-results\` from [results.jsonl](results.jsonl); not to be edited. [README.md](README.md) says what the words mean.

## What was measured

${what(run)}
Limits:

${limits(figures)}

## Figures

${BEGIN}
${excerpt(figures)}
${END}
`,
  of(figures, "rate").some((r) => SHORT.includes(r.from)) ? `## Rates\n\n${rateTable(figures, (r) => SHORT.includes(r.from))}` : "",
  bounds.length > 0 ? `## Bounds of accuracy

${table(["figure", "measured", "bound", ""], bounds.map((b) => [`${title(b.effect)}: ${b.of ? `${b.of}; ` : ""}${b.figure}`, `${span(b)} ${b.unit}`, bound(b), verdict(b)]))}` : "",
  realScenes(figures) ? `## Real scenes\n\n${realScenes(figures)}` : "",
  of(figures, "rate").some(isBeside) ? `## Filters beside brute force\n\n${rateTable(figures, isBeside)}` : "",
  costs(figures) ? `## Costs\n\n${costs(figures)}` : "",
  skips.length > 0 ? `## What skipping saves

Pairs of frames of ${skips[0].side_px}×${skips[0].side_px} pixels that differ in one need; counters say that the skip is what did it.

${table(["skip: needed, and not", "rays", "bytes", "CPU time", ""], skips.map((s) => [`${s.skip}, ${s.name}: ${s.about}`, share(s.rays), share(s.bytes), share(s.cpu), s.holds ? "holds" : "**does not hold**"]))}` : ""]
    .filter(Boolean).join("\n");
}

function withExcerpt(text, figures) {
  const from = text.indexOf(BEGIN), to = text.indexOf(END);
  if (from < 0 || to < from) throw new Error(`README.md has no lines "${BEGIN}" and "${END}"`);
  return `${text.slice(0, from)}${BEGIN}\n${excerpt(figures)}\n${text.slice(to)}`;
}

const stored = () => readFileSync(FIGURES, "utf8").split("\n").filter(Boolean).map((l) => JSON.parse(l));

export function writeResults(o, lines) {
  const figures = figuresOf(lines, stored());
  writeFileSync(FIGURES, figures.map((f) => JSON.stringify(f) + "\n").join(""));
  writeFileSync(PAGE, page(figures));
  writeFileSync(README, withExcerpt(readFileSync(README, "utf8"), figures));
  console.error(`results: ${PAGE}`);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const figures = stored(), wrong = [[PAGE, page(figures)], [README, withExcerpt(readFileSync(README, "utf8"), figures)]].filter(([path, text]) => readFileSync(path, "utf8") !== text);
  for (const [path] of wrong) console.error(`${path} is not what results.jsonl gives: run make bench-results`);
  process.exitCode = wrong.length > 0 ? 1 : 0;
}

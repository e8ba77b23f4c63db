// The report's section of real scenes: errors beside two references over samples and over time, and the pictures side
// by side: reference, paths, filters, denoiser.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { programs } from "../accuracy/programs.mjs";
import { ofPart } from "../judged.mjs";
import { lines } from "../plot/lines.mjs";
import { realBounds } from "../real/bounds.mjs";
import { equalCpu, shownError } from "../real/equal_cpu.mjs";
import { details, escape, number, plots, table, times, verdict } from "./html.mjs";

const NAMES = { none: "none", auto: "auto", oidn: "OIDN" }, ORDER = ["none", "auto", "oidn"];
const SHOWN_SPP = [4, 16], TIMES = 5;

const methodsOf = (rows) => [...new Set(rows.map((r) => r.method))].sort((a, b) => ORDER.indexOf(a) - ORDER.indexOf(b));
const nameOf = (method) => NAMES[method] ?? method;
// Of one picture: which paths a denoiser had, if they are not this build's.
const rowName = (r) => r.paths === "older" ? `${nameOf(r.method)} (older paths)` : nameOf(r.method);
const decibels = (v) => v === null ? "hidden" : v.toFixed(2);

function plotsOf(scene, rows) {
  const series = (x) => methodsOf(rows).map((method) => ({ name: nameOf(method), points: rows.filter((r) => r.method === method).map((r) => [x(r), shownError(r)]) }));
  const none = rows.filter((r) => r.method === "none").map((r) => [r.spp, shownError(r)]), xTicks = [...new Set(rows.map((r) => r.spp))];
  const common = { yLabel: "RMSE of sRGB" };
  return {
    samples: lines({ ...common, title: `${scene}: error against samples`, xLabel: "samples a pixel", series: series((r) => r.spp), xTicks,
      guide: none.length > 1 ? { slope: -0.5, through: none[0], label: "1/√samples" } : undefined }),
    seconds: lines({ ...common, title: `${scene}: error against CPU time`, xLabel: "CPU seconds, from samples to picture", series: series((r) => r.picture_s ?? NaN) }) };
}

// Counts whose pictures are shown: 4 and 16, or the most that there are.
function shownCounts(rows) {
  const counts = [...new Set(rows.map((r) => r.spp))], wanted = counts.filter((spp) => SHOWN_SPP.includes(spp));
  return wanted.length > 0 ? wanted : counts.slice(-1);
}

// Reference, and each method's picture with what it is off below, as files that a click shows at full size.
function views(o, tools, scene, rows, spp) {
  const shown = rows.filter((r) => r.spp === spp && existsSync(r.picture) && existsSync(r.reference_picture)), folder = `${o.out}/report/views`;
  if (shown.length === 0) return "";
  mkdirSync(folder, { recursive: true });
  const { width, height, reference_picture: reference } = shown[0];
  const image = (name, alt, scale, picture, minus) => {
    const file = `${scene}-${name}.png`;
    writeFileSync(`${folder}/${file}`, tools.piece(picture, "beauty", [0, 0, width, height], 1, scale, ...(minus ? [minus] : [])));
    return `<a href="views/${file}"><img src="views/${file}" alt="${escape(alt)}" width="${width}" height="${height}" loading="lazy"></a>`;
  };
  const figure = (words, ...images) => `<figure>${images.join("")}<figcaption>${words}</figcaption></figure>`;
  return `<h4>${spp} samples a pixel</h4><div class="views">${[
    figure(`reference; below the others: ${TIMES} times what they are off`, image("reference", `${scene}: the reference`, 1, reference)),
    ...shown.map((r) => figure(`<strong>${escape(rowName(r))}</strong><br>${decibels(r.psnr_db)} dB, FLIP ${number(r.flip)}`,
      image(`${r.method}-${spp}`, `${scene} by ${nameOf(r.method)} at ${spp} samples a pixel`, 1, r.picture),
      image(`${r.method}-${spp}-error`, `${TIMES} times the absolute error of ${nameOf(r.method)}`, TIMES, r.picture, reference)))].join("\n")}</div>`;
}

// A figure, and its bound if it has one.
const judged = (words, b) => b ? `${words} ${verdict(b.ok, `${b.relation === ">=" ? "≥" : "≤"} ${b.bound}`)}` : words;
const boundOf = (bounds, row, unit) => row.method === "auto" ? bounds.find((b) => b.scene === row.scene && b.spp === row.spp && b.unit === unit) : undefined;

function figures(rows, bounds) {
  const cost = (r, of) => r.cpu_min_s ? number(of(r)) : "–", scaled = (r) => r.denoiser_s ? `${number(r.denoiser_s)} (scaled)` : "–";
  return table("Errors without the references' own noise, and the least CPU seconds of the runs", ["method, samples", "psnr_db", "rmse01", "relmse999", "FLIP", "CPU s: tracing", "filters", "from samples to picture", "tracing over none's", "filters, s a megapixel"],
    rows.map((r) => [`${escape(rowName(r))}, ${r.spp} spp`, judged(decibels(r.psnr_db), boundOf(bounds, r, "dB")), number(r.rmse01), number(r.relmse999), number(r.flip),
      cost(r, () => r.cpu_min_s.trace), r.method === "oidn" ? scaled(r) : cost(r, () => r.filters_s_per_megapixel * r.megapixels), number(r.picture_s),
      judged(times(r.trace_over_none), boundOf(bounds, r, "times")), judged(cost(r, () => r.filters_s_per_megapixel), boundOf(bounds, r, "s"))]));
}

// All scenes at once: psnr_db by method.
function overview(rows, bounds) {
  const methods = methodsOf(rows), steps = [...new Map(rows.map((r) => [`${r.scene}, ${r.spp} spp`, r])).entries()];
  return table("psnr_db of all scenes, dB", ["scene, samples", ...methods.map(nameOf)], steps.map(([step, { scene, spp }]) => [escape(step), ...methods.map((method) => {
    const row = rows.find((r) => r.scene === scene && r.spp === spp && r.method === method);
    return row ? judged(decibels(row.psnr_db), boundOf(bounds, row, "dB")) : "–";
  })]));
}

// What both give for as much CPU time.
function equalTable(rows) {
  return table("At equal CPU time: the denoiser on paths, and auto with the samples that it has in that time; * extrapolated", ["scene, samples of OIDN", "CPU s, from samples to picture", "of these OIDN's, scaled", "OIDN, dB", "auto, dB", "auto's samples", "OIDN, FLIP", "auto, FLIP"],
    equalCpu(rows).map((e) => [`${escape(e.scene)}, ${e.spp} spp`, number(e.seconds), number(e.denoiser_s), decibels(e.oidn.psnr_db), `${decibels(e.auto.psnr_db)}${e.outside ? " *" : ""}`,
      number(e.auto.spp), number(e.oidn.flip), number(e.auto.flip)]));
}

// Whose paths the denoiser had, and what is known of its time.
function denoiserWords(rows) {
  const denoised = rows.filter((r) => r.method === "oidn"), own = denoised.filter((r) => r.paths !== "older"), program = own.filter((r) => r.program_s).map((r) => r.program_s / r.megapixels);
  if (denoised.length === 0) return "";
  const older = own.length < denoised.length ? "<strong>Its pictures named “older paths” are of an older build's paths, whose light samples were worse</strong>: the weights were not there when this was measured (<code>make peer-weights</code>)." : "";
  if (own.length === 0) return older;
  return `It had the very paths of <em>none</em>: Intel's trained weights in a program of ours that computes the same network. Its CPU time is not measured but <strong>scaled</strong> from another machine's: 2.6 CPU seconds a megapixel, as this machine's tracing of the Cornell box is to that one's. Our program took ${number(Math.min(...program))} to ${number(Math.max(...program))} here. ${older}`;
}

function stageTable(rows) {
  const measured = rows.filter((r) => r.cpu_min_s), stages = Object.keys(measured[0]?.cpu_min_s ?? {});
  return details("CPU seconds by stage", table("The least of the runs, CPU seconds by stage", ["method, samples", ...stages],
    measured.map((r) => [`${escape(nameOf(r.method))}, ${r.spp} spp`, ...stages.map((stage) => number(r.cpu_min_s[stage]))])));
}

function article(o, tools, scene, rows, bounds) {
  const drawn = plotsOf(scene, rows), [{ about, width, height }] = rows;
  for (const [name, svg] of Object.entries(drawn)) if (svg) writeFileSync(`${o.out}/report/plots/${scene}-real-${name}.svg`, svg);
  return `<article aria-labelledby="real-${scene}"><h3 id="real-${scene}">${escape(scene)}</h3><p>${escape(about)}; ${width}×${height} pixels.</p>
${figures(rows, bounds)}${shownCounts(rows).map((spp) => views(o, tools, scene, rows, spp)).join("\n")}${plots(drawn.samples, drawn.seconds)}${stageTable(rows)}</article>`;
}

// null when there are no such lines.
export function realSection(o, all) {
  const rows = ofPart(all, "real").sort((a, b) => a.scene.localeCompare(b.scene) || a.spp - b.spp || ORDER.indexOf(a.method) - ORDER.indexOf(b.method));
  if (rows.length === 0) return null;
  mkdirSync(`${o.out}/real`, { recursive: true });
  // Bounds are about the scenes of the peers folder.
  const tools = programs(o.build, `${o.out}/real`), bounds = o.mode === "full" ? realBounds(rows) : [], scenes = [...new Set(rows.map((r) => r.scene))];
  return { id: "real", title: "Real scenes", html: `<p>Pictures beside two independent references each: the product of what they are off beside the one and beside the other has no share of the references' own noise in its mean (<code>shearwater compare --reference-pair</code>). "Hidden" is an error that is below what that noise lets one tell. <em>none</em> are paths without a filter, <em>auto</em> is what the service does by itself, <em>OIDN</em> what a neural denoiser (Intel Open Image Denoise with albedo and normal) makes of paths. ${denoiserWords(rows)}</p>
${overview(rows, bounds)}${equalTable(rows)}${scenes.map((scene) => article(o, tools, scene, rows.filter((r) => r.scene === scene), bounds)).join("\n")}` };
}

// The report's pages of pictures: effect by effect, scene by scene, errors over samples and over time, crops
// beside the reference, all figures.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { effects } from "../accuracy/effects.mjs";
import { curve, equalError, filterSeconds } from "../accuracy/factors.mjs";
import { programs } from "../accuracy/programs.mjs";
import { quoted } from "../judged.mjs";
import { stages } from "../plot/bars.mjs";
import { lines } from "../plot/lines.mjs";
import { details, escape, number, plots, table, times } from "./html.mjs";

const CROP_PX = 256, LEAST_PX = 40, GREY = 0.2;
const stepOf = (r) => r.mu ? `μ ${r.mu}, ${number(r.spp)} rays` : `${r.spp} spp`;
const methodsOf = (rows) => [...new Set(rows.map((r) => r.method))];

function plotsOf(scene, rows, effect) {
  const series = (x) => methodsOf(rows).map((name) => ({ name, points: curve(rows, scene.name, name, x) }));
  const average = curve(rows, scene.name, "average", (r) => r.spp), xTicks = [...new Set(rows.filter((r) => !r.mu).map((r) => r.spp))].sort((a, b) => a - b);
  return {
    samples: lines({ title: `${scene.name}: error against samples`, xLabel: effect.samples, yLabel: effect.error, series: series((r) => r.spp), xTicks,
      guide: average.length > 1 ? { slope: -0.5, through: average[0], label: "1/√samples" } : undefined }),
    seconds: lines({ title: `${scene.name}: error against CPU time`, xLabel: "CPU seconds, from samples to picture", yLabel: effect.error, series: series((r) => r.cpu_s.judged) }) };
}

// The scene's crop, of a picture of this side: never so small that nothing is to be seen.
function cropOf(scene, side) {
  const [width, height] = [0, 1].map((i) => Math.round(side * (scene.sides?.[i] ?? 1)));
  const [x, y, w, h] = scene.crop.map((v) => v * side / 512), size = Math.min(Math.max(Math.round(w), LEAST_PX), width, height);
  const from = (at, extent, most) => Math.min(Math.max(0, Math.round(at + extent / 2 - size / 2)), most - size);
  return [from(x, w, width), from(y, h, height), size, size];
}

// Crops of the pictures at the count that is quoted, and ten times what they are off.
function crops(o, tools, scene, rows, effect) {
  const shown = quoted(rows).filter((r) => r.picture && existsSync(r.picture) && existsSync(r.reference_picture));
  if (shown.length === 0) return "";
  const side = rows[0].side_px, crop = cropOf(scene, side), zoom = Math.min(8, Math.max(1, Math.round(CROP_PX / crop[2])));
  const scale = shown[0].judged.mean ? GREY / shown[0].judged.mean : 1, folder = `${o.out}/report/crops`;
  mkdirSync(folder, { recursive: true });
  const image = (name, alt, ...what) => {
    writeFileSync(`${folder}/${scene.name}-${name}.png`, tools.piece(what[0], effect.layer, crop, zoom, ...what.slice(1)));
    return `<img src="crops/${scene.name}-${name}.png" alt="${escape(alt)}" loading="lazy">`;
  };
  // A method's crop and its error are one below the other, however the row wraps.
  const figure = (words, ...images) => `<figure>${images.join("")}<figcaption>${words}</figcaption></figure>`, reference = shown[0].reference_picture;
  return `<div class="crops">${[
    figure(`reference, ${number(rows[0].reference.spp)} samples; below the others: ten times what they are off`, image("reference", `Crop of ${scene.name}: the converged reference`, reference, scale)),
    ...shown.map((r) => figure(`<strong>${r.method}</strong>, ${stepOf(r)}<br>RMSE ${number(r.judged.rmse)}`, image(r.method, `The same crop by ${r.method} at ${stepOf(r)}`, r.picture, scale),
      image(`${r.method}-error`, `Ten times the absolute error of ${r.method}`, r.picture, 10 * scale, reference)))].join("\n")}</div>`;
}

function figures(rows, effect) {
  const factors = effect.against.flatMap((name) => equalError(rows, name));
  const factor = (r, what) => {
    const f = factors.find((g) => g.method === r.method && g.spp === r.spp && g.against === "average");
    return f ? times(f[what]) + (f.extrapolated ? "*" : "") : "–";
  };
  const parts = Object.keys(effect.parts ?? {});
  return table("Every picture: errors of its judged pixels and of the beauty image, its cost, and how much more the plain average needs for that error (* beyond what was measured)",
    ["method, samples", "RMSE", "relMSE", "bias", "p99.9", ...parts.map((p) => `RMSE, ${p}`), "beauty RMSE", "light over the reference's", "CPU s", "of it filters", "wall s", "MB moved", "peak MB: server", "worker", "samples", "CPU time"],
    rows.map((r) => [`${r.method}, ${stepOf(r)}`, number(r.judged.rmse), number(r.judged.relmse), number(r.judged.bias), number(r.judged.p999),
      ...parts.map((p) => number(r[p]?.rmse)), number(r.beauty.rmse), r.beauty.energy.toFixed(4), number(r.cpu_s.judged), number(filterSeconds(r)), number(r.wall_s), number(r.bytes_received / 1e6),
      number(r.peak_rss_bytes.server / 1e6), number(r.peak_rss_bytes.worker / 1e6), factor(r, "samples"), factor(r, "seconds")]));
}

function article(o, tools, scene, rows, effect) {
  const drawn = plotsOf(scene, rows, effect), { reference, judged, side_px: side } = rows[0];
  const doubt = reference.doubt === null || reference.doubt === undefined ? "" : `, which leaves a standard error of ${(100 * reference.doubt).toFixed(1)} % at most in the errors quoted`;
  for (const [name, svg] of Object.entries(drawn)) if (svg) writeFileSync(`${o.out}/report/plots/${scene.name}-${name}.svg`, svg);
  return `<article aria-labelledby="scene-${scene.name}"><h3 id="scene-${scene.name}">${escape(scene.name)}</h3>
<p>${escape(scene.about)}. Side ${side} px; judged: ${escape(effect.region)}, ${number(judged.pixels)} pixels. Reference of ${number(reference.spp)} samples, whose halves are ${number(reference.halves_rmse)} apart${doubt}${reference.good ? "" : " – more than a tenth of the smallest error judged"}.</p>
${plots(drawn.samples, drawn.seconds)}${crops(o, tools, scene, rows, effect)}${details(`All ${rows.length} pictures of ${scene.name}`, figures(rows, effect))}</article>`;
}

// CPU time by stage, all scenes of an effect together, at the count that is quoted.
function stageBars(rows, effect) {
  const here = quoted(rows), sum = (list) => list.reduce((total, r) => {
    for (const [stage, s] of Object.entries(r.cpu_s)) total[stage] = (total[stage] ?? 0) + s;
    return total;
  }, {});
  return stages(`${effect.title}: CPU time by stage, ${effect.at} ${effect.samples}`, methodsOf(here).map((name) => ({ name, cpu_s: sum(here.filter((r) => r.method === name)) })));
}

// rows: as judged.mjs has them. Writes plots and crops beside the page; returns its sections and bars of stages.
export function accuracySections(o, rows, scenes) {
  const tools = programs(o.build, o.out);
  return Object.values(effects).filter((e) => rows.some((r) => r.effect === e.name)).map((effect) => {
    const mine = rows.filter((r) => r.effect === effect.name), bars = stageBars(mine, effect);
    if (bars) writeFileSync(`${o.out}/report/plots/${effect.name}-stages.svg`, bars);
    const articles = scenes.filter((s) => mine.some((r) => r.scene === s.name))
      .map((s) => article(o, tools, s, mine.filter((r) => r.scene === s.name), effect));
    return { id: `accuracy-${effect.name}`, title: `Errors: ${effect.title}`,
      html: `<p>Errors are ${escape(effect.says)}. Methods are compared on the same samples; <code>average</code> is their mean without a filter. Crops are of ${effect.at} ${escape(effect.samples)}.</p>
${plots(bars)}${bars ? `<p class="soft">Other: starting and ending the processes of one frame, and what no stage counts.</p>` : ""}${articles.join("\n")}` };
  });
}

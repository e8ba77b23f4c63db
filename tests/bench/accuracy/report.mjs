// The report page: bounds, then each scene with its plots and pieces of its pictures. One file; crops
// of the boundaries of focus are kept beside it as well, in crops/.
import { mkdirSync, writeFileSync } from "node:fs";
import { effectOf, effects } from "./effects.mjs";
import { equalError, filterSeconds } from "./factors.mjs";
import { logLog, stages } from "./plot.mjs";

const STYLE = `body{font:15px/1.5 system-ui,sans-serif;max-width:1120px;margin:2em auto;padding:0 1em;color:#111}
table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #e5e7eb}
td:first-child,th:first-child{text-align:left}.missed{color:#b91c1c;font-weight:600}figure{display:inline-block;margin:.3em}
figcaption{font-size:12px;color:#374151}img{image-rendering:pixelated;display:block}.row{display:flex;flex-wrap:wrap}`;

const number = (v) => v === null || v === undefined || !Number.isFinite(v) ? "" : v === 0 ? "0"
  : Math.abs(v) >= 0.01 && Math.abs(v) < 1e4 ? String(Number(v.toPrecision(3))) : v.toExponential(2);
const table = (head, rows) => `<table><tr>${head.map((h) => `<th>${h}</th>`).join("")}</tr>\n` +
  rows.map((r) => `<tr>${r.map((c) => `<td>${c}</td>`).join("")}</tr>`).join("\n") + "</table>";
const verdict = (b) => b.bound === null ? "" : b.ok ? "reached" : '<span class="missed">MISSED</span>';

function boundsTable(bounds) {
  if (bounds.length === 0) return "<p>No bound could be measured by what was run.</p>";
  return table(["effect", "figure (median over scenes)", "measured", "bound", "unit", "least … most", "scenes", ""],
    bounds.map((b) => [b.effect, b.figure, number(b.value), b.bound === null ? "" : `${b.relation} ${number(b.bound)}`, b.unit,
      b.least === undefined ? "" : `${number(b.least)} … ${number(b.most)}`, b.scenes, verdict(b)]));
}

const seriesOf = (rows, x) => [...new Set(rows.map((r) => r.method))].map((name) => ({ name,
  points: rows.filter((r) => r.method === name).map((r) => [x(r), r.judged.rmse]) }));

// The plots of one scene, by name.
export function plotsOf(scene, rows) {
  const effect = effectOf(scene), quoted = rows.filter((r) => r.spp === effect.at || r.mu === 1);
  return {
    samples: logLog(`${scene.name}: error against samples`, effect.samples, effect.error,
      seriesOf(rows, (r) => r.spp), { slope: -0.5, xTicks: [...new Set(rows.map((r) => r.spp))].sort((a, b) => a - b) }),
    seconds: logLog(`${scene.name}: error against CPU time`, "CPU seconds from samples to picture", effect.error,
      seriesOf(rows, (r) => r.cpu_s.judged)),
    stages: quoted.length > 0 ? stages(`${scene.name}: CPU seconds by stage, ${effect.at} spp`,
      quoted.map((r) => ({ name: r.method, cpu_s: r.cpu_s }))) : "" };
}

function pieces(tools, scene, rows, reference, side) {
  const crop = scene.crop.map((v) => Math.round(v * side / 512)), zoom = side < 512 ? 4 : 2;
  const { at, layer } = effectOf(scene), quoted = rows.filter((r) => r.spp === at || r.mu === 1);
  // Indirect light may be dim: its mean becomes a middle grey.
  const scale = quoted[0]?.judged.mean ? 0.2 / quoted[0].judged.mean : 1;
  const show = (words, ...what) => `<figure><img src="data:image/png;base64,${tools.piece(what[0], layer, crop, zoom, ...what.slice(1))
    .toString("base64")}" alt="${words}"><figcaption>${words}</figcaption></figure>`;
  const out = [show("reference", reference.path, scale)], errors = [];
  for (const row of quoted) {
    out.push(show(`${row.method}, ${row.spp} spp`, row.picture, scale));
    errors.push(show(`${row.method}: error × 10`, row.picture, 10 * scale, reference.path));
  }
  return `<div class="row">${out.join("")}</div><div class="row">${errors.join("")}</div>`;
}

const EDGE_ZOOM = 4;

// Where things in and out of focus meet: as large as a person can judge them, and kept as files.
function boundaries(tools, scene, rows, reference, o) {
  const { at, layer } = effectOf(scene), quoted = rows.filter((r) => r.spp === at), scale = quoted[0] ? 0.2 / quoted[0].judged.mean : 1;
  if (!scene.boundaries || quoted.length === 0) return "";
  mkdirSync(`${o.out}/crops`, { recursive: true });
  const show = (crop, k, name, picture) => {
    const png = tools.piece(picture, layer, crop.map((v) => Math.round(v * o.side / 512)), EDGE_ZOOM, scale);
    writeFileSync(`${o.out}/crops/${scene.name}-${k + 1}-${name}.png`, png);
    return `<figure><img src="data:image/png;base64,${png.toString("base64")}" alt="${name}"><figcaption>${name}</figcaption></figure>`;
  };
  return `<h3>Boundaries of focus, ${at} ${effectOf(scene).samples}</h3>` + scene.boundaries.map((crop, k) =>
    `<div class="row">${[["reference", reference.path], ...quoted.map((r) => [r.method, r.picture])].map(([name, picture]) =>
      show(crop, k, name, picture)).join("")}</div>`).join("\n");
}

function figuresTable(rows, effect) {
  const factors = effect.against.flatMap((name) => equalError(rows, name));
  const factor = (r, against, what) => {
    const f = factors.find((g) => g.method === r.method && g.spp === r.spp && g.against === against);
    return f ? number(f[what]) + (f.extrapolated ? "*" : "") : "";
  };
  const others = effect.against.slice(1);
  return table(["method", "spp", effect.error, "relMSE", "bias", "p99.9", "RMSE, all", "RMSE, beauty", "energy", "CPU s", "filter s",
    "samples ×", "time ×", ...others.map((name) => `samples × (${name})`)],
  rows.map((r) => [r.method, r.spp, number(r.judged.rmse), number(r.judged.relmse), number(r.judged.bias),
    number(r.judged.p999), number(r.rmse), number(r.beauty.rmse), r.beauty.energy.toFixed(4), number(r.cpu_s.judged),
    number(filterSeconds(r)), factor(r, "average", "samples"), factor(r, "average", "seconds"),
    ...others.map((name) => factor(r, name, "samples"))]));
}

function section(tools, { scene, rows, reference }, o) {
  const said = rows[0].reference, plots = plotsOf(scene, rows), effect = effectOf(scene);
  return `<h2>${scene.name}</h2><p>${effect.title}: ${scene.about}. Judged: ${effect.region}, ${rows[0].judged.pixels} pixels. Reference: ${said.spp}
samples; its halves differ by ${number(said.halves_rmse)}${said.doubt === null ? "" : `, which leaves a standard error of ${(100 * said.doubt).toFixed(1)} % at most in the errors at ${effect.at} ${effect.samples}`}${said.good ? "" : ', <span class="missed">too much for the smallest error</span>'}.</p>
<div class="row">${plots.samples}${plots.seconds}</div>${plots.stages}
${pieces(tools, scene, rows, reference, o.side)}${boundaries(tools, scene, rows, reference, o)}${figuresTable(rows, effect)}`;
}

// results: [{scene, rows, reference}]
export function writeReport(tools, results, bounds, o) {
  const shown = Object.values(effects).filter((e) => results.some((r) => r.scene.effect === e.name));
  const page = `<!doctype html><html lang="en"><meta charset="utf-8"><title>Accuracy</title><style>${STYLE}</style>
<h1>Accuracy of ${shown.map((e) => e.title).join(" and ")}</h1>
<p>${o.side} × ${o.side} pixels unless said, seed ${o.seed}, build ${o.build}. CPU seconds are tracing, packing, decoding and reconstruction with all filters. Energy is the
whole picture's light over the reference's. × is how much more of it another method (the plain average unless said) needs for the same error;
* lies beyond what was measured. Errors are</p><ul>${shown.map((e) => `<li>${e.title}: ${e.says}.</li>`).join("")}</ul>
${boundsTable(bounds)}
${[...o.refused].map(([method, why]) => `<p>Not measured: ${method} (${why.replace(/</g, "&lt;")})</p>`).join("")}
${results.map((r) => section(tools, r, o)).join("\n")}</html>\n`;
  writeFileSync(`${o.out}/report.html`, page);
}

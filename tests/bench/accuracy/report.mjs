// The report page: bounds, then each scene with its plots and pieces of its pictures. One file.
import { writeFileSync } from "node:fs";
import { equalError } from "./factors.mjs";
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
  return table(["figure (median over scenes)", "measured", "bound", "unit", "least … most", "scenes", ""],
    bounds.map((b) => [b.figure, number(b.value), b.bound === null ? "" : `${b.relation} ${number(b.bound)}`, b.unit,
      b.least === undefined ? "" : `${number(b.least)} … ${number(b.most)}`, b.scenes, verdict(b)]));
}

const seriesOf = (rows, x) => [...new Set(rows.map((r) => r.method))].map((name) => ({ name,
  points: rows.filter((r) => r.method === name).map((r) => [x(r), r.penumbra.rmse]) }));

// The plots of one scene, by name.
export function plotsOf(scene, rows) {
  const nine = rows.filter((r) => r.spp === 9);
  return {
    samples: logLog(`${scene.name}: error against samples`, "samples a light and pixel", "RMSE, penumbra",
      seriesOf(rows, (r) => r.spp), { slope: -0.5, xTicks: [...new Set(rows.map((r) => r.spp))].sort((a, b) => a - b) }),
    seconds: logLog(`${scene.name}: error against CPU time`, "CPU seconds from samples to picture", "RMSE, penumbra",
      seriesOf(rows, (r) => r.cpu_s.judged)),
    stages: nine.length > 0 ? stages(`${scene.name}: CPU seconds by stage, 9 spp`,
      nine.map((r) => ({ name: r.method, cpu_s: r.cpu_s }))) : "" };
}

function pieces(tools, scene, rows, reference, side) {
  const crop = scene.crop.map((v) => Math.round(v * side / 512)), zoom = side < 512 ? 4 : 2;
  const show = (bytes, words) => `<figure><img src="data:image/png;base64,${bytes.toString("base64")}" alt="${words}">` +
    `<figcaption>${words}</figcaption></figure>`;
  const out = [show(tools.piece(reference.path, crop, zoom, 1), "reference")], errors = [];
  for (const row of rows.filter((r) => r.spp === 9)) {
    out.push(show(tools.piece(row.picture, crop, zoom, 1), `${row.method}, 9 spp`));
    errors.push(show(tools.piece(row.picture, crop, zoom, 10, reference.path), `${row.method}: error × 10`));
  }
  return `<div class="row">${out.join("")}</div><div class="row">${errors.join("")}</div>`;
}

function figuresTable(rows) {
  const factors = [...equalError(rows, "average"), ...equalError(rows, "axis_aligned")];
  const factor = (r, against, what) => {
    const f = factors.find((g) => g.method === r.method && g.spp === r.spp && g.against === against);
    return f ? number(f[what]) + (f.extrapolated ? "*" : "") : "";
  };
  return table(["method", "spp", "RMSE, penumbra", "relMSE", "bias", "p99.9", "RMSE, all", "RMSE, beauty", "CPU s", "filter s",
    "samples ×", "time ×", "samples × (axis)"],
  rows.map((r) => [r.method, r.spp, number(r.penumbra.rmse), number(r.penumbra.relmse), number(r.penumbra.bias),
    number(r.penumbra.p999), number(r.rmse), number(r.beauty.rmse), number(r.cpu_s.judged), number(r.cpu_s.shadow),
    factor(r, "average", "samples"), factor(r, "average", "seconds"), factor(r, "axis_aligned", "samples")]));
}

function section(tools, { scene, rows, reference }, side) {
  const said = rows[0].reference, plots = plotsOf(scene, rows);
  return `<h2>${scene.name}</h2><p>${scene.about}. Penumbra: ${rows[0].penumbra.pixels} pixels. Reference: ${said.spp} samples a light;
its halves differ by ${number(said.halves_rmse)}${said.good ? "" : ', <span class="missed">above a tenth of the smallest error</span>'}.</p>
<div class="row">${plots.samples}${plots.seconds}</div>${plots.stages}
${pieces(tools, scene, rows, reference, side)}${figuresTable(rows)}`;
}

// results: [{scene, rows, reference}]
export function writeReport(tools, results, bounds, o) {
  const page = `<!doctype html><html lang="en"><meta charset="utf-8"><title>Accuracy</title><style>${STYLE}</style>
<h1>Accuracy of soft shadows</h1>
<p>${o.side} × ${o.side} pixels, seed ${o.seed}, build ${o.build}. Errors are of the light that a white surface would send at pixel centres
(layer diffuse_direct) where the reference's visibility lies in (0.02, 0.98), unless said otherwise; CPU seconds are tracing, packing,
decoding and reconstruction. × is how much more of it the plain average (or axis-aligned filtering) needs for the same error; * lies
beyond what was measured.</p>
${boundsTable(bounds)}
${[...o.refused].map(([method, why]) => `<p>Not measured: ${method} (${why.replace(/</g, "&lt;")})</p>`).join("")}
${results.map((r) => section(tools, r, o.side)).join("\n")}</html>\n`;
  writeFileSync(`${o.out}/report.html`, page);
}

// The report: one page with its plots, crops and lines beside it, in OUT/report.
import { copyFileSync, existsSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { effects } from "../accuracy/effects.mjs";
import { KINDS, sentence } from "../gate.mjs";
import { effectBounds, headlines, JUDGED_SIDE_PX, ofPart, rowsOf, sidesOf } from "../judged.mjs";
import { scenes } from "../scenes/scenes.mjs";
import { accuracySections } from "./accuracy.mjs";
import { costSection, skipSection } from "./costs.mjs";
import { bytes, details, escape, number, STYLE, table, times, verdict } from "./html.mjs";
import { realSection } from "./real.mjs";

const gains = (h, what) => h[what] ? `${times(h[what].value)}` : "–";
const range = (s) => s && s.scenes > 1 ? `${number(s.least)} … ${number(s.most)}` : "";

function cards(rows) {
  const shown = headlines(rows).filter((h) => h.samples);
  return shown.length === 0 ? "" : `<ul class="cards">${shown.map((h) => `<li><span>${escape(h.effect.title)}</span><b>${gains(h, "samples")}</b>
<span class="soft">as many samples, and ${gains(h, "seconds")} the CPU time, are what the plain average needs for the error of <em>${escape(h.method)}</em> at ${h.effect.at} ${escape(h.effect.samples)}${h.samples.scenes > 1 ? ` (samples: ${range(h.samples)})` : ""}</span></li>`).join("\n")}</ul>`;
}

const boundCells = (b) => [`${b.of ? '<span class="soft">…</span> ' : ""}${escape(b.figure)}`, number(b.value), b.bound === null ? "" : `${b.relation === ">=" ? "≥" : "≤"} ${number(b.bound)}`,
  escape(b.unit), b.least === b.most ? "" : `${number(b.least)} … ${number(b.most)}`, b.scenes, b.bound === null ? "" : b.judged ? verdict(b.ok) : verdict(null, "not judged here")];

const boundsTables = (found) => Object.values(effects).map((e) => table(`${e.title}: medians over scenes, or the worst where it says every scene`,
  ["figure", "measured", "bound", "unit", "least … most", "scenes", "verdict"], found.filter((b) => b.effect === e.name).map(boundCells), [3])).join("\n");

const figureTable = (caption, found) => table(caption, ["figure", "measured", "bound", "unit", "verdict"],
  found.map((l) => [escape(l.figure), number(l.value), escape(l.bound.replace(">=", "≥").replace("<=", "≤")), escape(l.unit), verdict(l.ok)]), [3]);
const rates = (figures) => figureTable("Rates and shares beside their bounds", figures.filter((l) => l.from !== "real")) +
  figureTable("Pictures of real scenes beside their bounds", figures.filter((l) => l.from === "real"));

function boundSection(o, lines, rows) {
  const found = effectBounds(rows, scenes), judged = found.filter((b) => b.judged), missed = judged.filter((b) => !b.ok), figures = ofPart(lines, "figure");
  const lost = missed.length + figures.filter((l) => !l.ok).length, asked = judged.length + figures.length;
  const why = found.some((b) => b.bound !== null && !b.judged)
    ? `<p>Bounds of accuracy are about all scenes at ${JUDGED_SIDE_PX} px and more, since filters are as wide as pixels say; pictures here have ${sidesOf(rows).join(", ")} px, so that figures are shown and bounds are not judged where that is so.</p>` : "";
  const said = asked === 0 ? "<p>No bound was judged by what was run.</p>" : `<p>${verdict(lost === 0, lost === 0 ? `all ${asked} bounds that were judged hold` : `${lost} of ${asked} bounds that were judged are missed`)}</p>`;
  return { id: "bounds", title: "Bounds", html: `${said}${why}${boundsTables(found)}${rates(figures)}` };
}

function gateSection(gate) {
  if (!gate) return null;
  const of = (verdict) => gate.moved.filter((m) => m.verdict === verdict), worse = of("worse"), others = [...of("better"), ...of("moved")];
  const list = (items) => items.length > 0 ? `<ul>${items.map((m) => `<li>${escape(sentence(m))}</li>`).join("\n")}</ul>` : "";
  return { id: "gate", title: "Beside the committed figures", html: `<p>${verdict(gate.ok, gate.ok ? "nothing got worse than is allowed" : `${worse.length + gate.missing.length} figures are worse or missing`)}:
${gate.moved.length} figures against those of build <code>${escape(gate.committed.build)}</code> (${escape(gate.committed.machine)}): ${of("still").length} are as they were, ${of("moved").length} moved within what is allowed, ${of("better").length} are better.</p>
${list(worse)}${details(`${others.length} others that moved`, list(others))}
<p class="soft">Allowed: ${Object.entries(KINDS).map(([name, k]) => `${name} +${100 * k.floor} %${k.noises ? ` or ${k.noises} times its noise` : ""}`).join(", ")}. Noise is the spread over runs with other seeds when the figures were accepted.</p>` };
}

function howSection(o, lines) {
  const machine = lines.find((l) => l.part === "machine") ?? {}, took = ofPart(lines, "took");
  return { id: "how", title: "How it was measured", html: `<dl><dt>build</dt><dd><code>${escape(machine.build)}</code></dd>
<dt>machine</dt><dd>${escape(machine.cpu)}, ${machine.cores} cores, ${escape(machine.instructions)}, ${bytes(machine.memory_bytes ?? 0)}, Linux ${escape(machine.kernel)}</dd>
<dt>other load</dt><dd>${number(machine.load_before)} processes a core wanted to run in the minute before</dd>
<dt>took</dt><dd>${took.map((l) => `${escape(l.of)} ${number(l.wall_s)} s`).join(", ") || "–"}</dd></dl>
<ul><li>References are stratified Monte Carlo of the same integrals in two independent halves, kept under a digest of scene and job, and made again when a small probe shows that this build's light is another. What the halves differ in bounds what can be said; beside each scene it says so.</li>
<li>CPU seconds are the operating system's, by stage, over all processes. In accuracy they are the least of the runs, since other work only adds; elsewhere medians. Wall time by stage comes from the job's log and its stream of tiles; stages overlap while tiles come.</li>
<li>Machines are noisy and this one may have been shared: ratios of one run are what to quote. Peak memory is of a process's life; bytes are samples as they came over the link.</li>
<li>Everything on this page was printed as a line of JSON: <a href="lines.jsonl">lines.jsonl</a>. Plots lie beside it as SVG files, in <code>plots/</code>.</li></ul>` };
}

// lines: of the store; gate: what gate.mjs found, or null. Returns the page's path.
export function writeReport(o, lines, gate) {
  const folder = `${o.out}/report`, rows = rowsOf(lines), machine = lines.find((l) => l.part === "machine") ?? {};
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(`${folder}/plots`, { recursive: true });
  if (existsSync(`${o.out}/lines.jsonl`)) copyFileSync(`${o.out}/lines.jsonl`, `${folder}/lines.jsonl`);
  const sections = [boundSection(o, lines, rows), gateSection(gate), ...accuracySections(o, rows, scenes), realSection(o, lines), costSection(o, lines), skipSection(o, lines), howSection(o, lines)].filter(Boolean);
  const shown = [...rows, ...ofPart(lines, "real").filter((l) => l.runs)];
  const sides = sidesOf(rows), day = lines.map((l) => l.time).sort().at(-1)?.slice(0, 10) ?? "";
  writeFileSync(`${folder}/index.html`, `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1"><title>Shearwater: measured</title>
<link rel="icon" href="data:,"><style>${STYLE}</style></head><body><a class="skip" href="#bounds">Skip to the figures</a>
<header><h1>Shearwater: how much error for how much time</h1>
<p>Build <code>${escape(machine.build ?? "")}</code>, ${escape(day)}, ${escape(machine.cpu ?? "")} with ${machine.cores ?? "?"} cores (${escape(machine.instructions ?? "?")}). ${shown.length} pictures of ${new Set(shown.map((r) => r.scene)).size} scenes${sides.length ? `, ${sides.join(" and ")} px wide` : ""}, against converged references.</p></header>
<nav aria-label="Sections"><ul>${sections.map((s) => `<li><a href="#${s.id}">${escape(s.title)}</a></li>`).join("")}</ul></nav>
<main>${cards(rows)}${sections.map((s) => `<section id="${s.id}" aria-labelledby="${s.id}-title"><h2 id="${s.id}-title">${escape(s.title)}</h2>${s.html}</section>`).join("\n")}</main>
<footer><p>Made by <code>tests/bench/bench.mjs</code> from ${lines.length} lines.</p></footer></body></html>
`);
  return `${folder}/index.html`;
}

// How the service bears load, part by part.
//   node tests/load/load.mjs BUILD_DIR [parts=fair,...] [report=PATH] [name=value ...]
// Real coordinator, real workers, clients over HTTP. Prints TAP, with a JSON line for each part, and writes a
// page with plots. Each part's own numbers are its `defaults`.
import { mkdirSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import { lines } from "../bench/plot/lines.mjs";
import { escape } from "../bench/plot/svg.mjs";
import { done, failed, options } from "./service.mjs";
import * as fair from "./parts/fair.mjs";
import * as quota from "./parts/quota.mjs";
import * as queue from "./parts/queue.mjs";
import * as viewers from "./parts/viewers.mjs";
import * as weights from "./parts/weights.mjs";

const PARTS = { fair, weights, quota, queue, viewers };

const build = process.argv[2];
const want = options(Object.assign({ parts: Object.keys(PARTS).join(","), report: `${build}/load/report.html` },
    ...Object.values(PARTS).map((part) => part.defaults)));

const shown = (value) => typeof value !== "number" ? String(value) : Number.isInteger(value) ? String(value) : value.toPrecision(4);

const section = ({ part, ok, figures, plots, notes = [] }) => {
    const rows = Object.entries(figures).map(([name, value]) => `<tr><th scope="row">${escape(name)}</th><td>${escape(shown(value))}</td></tr>`);
    return `<section><h2>${escape(part)}: ${ok ? "holds" : "missed"}</h2>\n${notes.map((text) => `<p>${escape(text)}</p>`).join("\n")}\n<table>${rows.join("\n")}</table>\n${plots.map(lines).join("\n")}</section>`;
};

const page = (results) => `<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Load</title>
<style>body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}
th{text-align:left;font-weight:400;padding-right:2rem}td{text-align:right;font-variant-numeric:tabular-nums}</style>
<h1>Load</h1><p>${new Date().toISOString()}</p>
${results.map(section).join("\n")}
</html>
`;

const names = want.parts.split(",");
for (const name of names) if (!PARTS[name]) throw new Error(`parts=${name}: not one of ${Object.keys(PARTS).join(", ")}`);
const results = [];
for (const part of names) {
    const before = failed(), { figures, plots, notes } = await PARTS[part].run(build, want), ok = failed() === before;
    results.push({ part, ok, figures, plots, notes });
    console.log(JSON.stringify({ part, ok, ...figures }));
}
mkdirSync(dirname(want.report), { recursive: true });
writeFileSync(want.report, page(results));
console.log(`# ${want.report}`);
done();

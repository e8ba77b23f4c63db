// The regression gate: figures of a run beside the committed ones, as ratios.
//   kind: what a figure is, and how far it may get worse. Errors and counts come out the same on every run
//   of the same code, so that little is allowed; times are ratios within one run, and vary.
//   noise: how much the figure varied over runs with other seeds, when it was accepted; it says what a
//   movement means, and what times may do.
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { filterSeconds } from "./accuracy/factors.mjs";
import { median, raysOf } from "./parts/runs.mjs";

// Of all of them less is better. floor: what is allowed in any case; noises: how many of its noises; still: what
// is not worth a word, such as the rounding of other processors. Wall time
// is not among them: it is the machine's other work that moves it.
export const KINDS = {
  error: { floor: 0.02, noises: 0, still: 1e-3 },
  count: { floor: 0.01, noises: 0, still: 1e-3 },
  bytes: { floor: 0.03, noises: 0, still: 1e-3 },
  time: { floor: 1, noises: 4, still: 0.25 } };

const mean = (values) => Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length);

function accuracyFigures(rows) {
  const found = {}, groups = new Map();
  for (const r of rows) {
    const step = r.mu ? `mu ${r.mu}` : `${r.spp} spp`, name = `${r.scene} ${r.method} ${step}`;
    found[`${name}: RMSE`] = { value: r.judged.rmse, kind: "error" };
    found[`${name}: rays a pixel`] = { value: raysOf(r.rays) / (1e6 * r.megapixels), kind: "count" };
    const group = `${r.effect} ${r.method}`;
    groups.set(group, [...(groups.get(group) ?? []), r]);
  }
  for (const [group, members] of groups) {
    // Of many pictures together: less noise than each has.
    found[`${group}, all: RMSE, geometric mean`] = { value: mean(members.map((r) => r.judged.rmse)), kind: "error" };
    const shares = members.map((r) => filterSeconds(r) / r.cpu_s.trace).filter((v) => v > 0);
    if (shares.length > 0) found[`${group}, all: filter's CPU time over tracing's`] = { value: median(shares), kind: "time" };
  }
  return found;
}

// Of pictures beside two references; an error that these hide has no figure.
function realFigures(rows) {
  const found = {}, shares = rows.map((r) => r.trace_over_none).filter(Boolean);
  for (const r of rows) {
    const name = `${r.scene} ${r.method} ${r.spp} spp`;
    if (r.rmse01) found[`${name}: RMSE`] = { value: r.rmse01, kind: "error" };
    found[`${name}: rays a pixel`] = { value: raysOf(r.rays) / (1e6 * r.megapixels), kind: "count" };
  }
  if (shares.length > 0) found["real auto, all: tracing's CPU time over that of none"] = { value: median(shares), kind: "time" };
  return found;
}

// Costs beside the cheapest of their kind: how they grow.
function growth(lines, name, of, per) {
  if (lines.length < 2) return {};
  const sorted = lines.slice().sort((a, b) => per(a) - per(b)), [first, last] = [sorted[0], sorted.at(-1)];
  return { [name(last, first)]: { value: (of(last) / per(last)) / (of(first) / per(first)), kind: "time" } };
}

function costFigures(lines) {
  const of = (part) => lines.filter((l) => l.part === part), found = {};
  for (const kind of new Set(of("resolution").map((l) => l.kind)))
    Object.assign(found, growth(of("resolution").filter((l) => l.kind === kind),
      (a, b) => `resolution, ${kind}: CPU time a pixel, ${a.height} lines over ${b.height}`, (l) => l.cpu_min_s.total, (l) => l.megapixels));
  const hills = of("triangles").sort((a, b) => a.triangles - b.triangles);
  if (hills.length > 1) found[`triangles: tracing's CPU time, ${hills.at(-1).triangles} over ${hills[0].triangles}`] =
    { value: hills.at(-1).cpu_min_s.trace / hills[0].cpu_min_s.trace, kind: "time" };
  for (const l of of("skips")) {
    const pixels = l.side_px * l.side_px, frames = [["needed", l.need], ["not needed", l.spare]];
    for (const [which, frame] of frames) {
      found[`${l.skip}, ${l.name} ${which}: rays a pixel`] = { value: frame.rays / pixels, kind: "count" };
      found[`${l.skip}, ${l.name} ${which}: bytes a pixel`] = { value: frame.bytes / pixels, kind: "bytes" };
    }
  }
  return found;
}

// {name: {value, kind}} of one run's lines; those of other seeds than the first are left out.
export const figuresOf = (lines) => ({ ...accuracyFigures(lines.filter((l) => l.part === "accuracy")),
  ...realFigures(lines.filter((l) => l.part === "real" && l.rays)), ...costFigures(lines) });

const percent = (ratio) => `${ratio >= 1 ? "+" : "−"}${(100 * Math.abs(ratio - 1)).toPrecision(3)} %`;

function movement(name, then, now, slack) {
  const { floor, noises, still } = KINDS[then.kind], ratio = now.value / then.value, moved = Math.log(ratio), noise = then.noise ?? 0;
  const allowed = Math.max(floor, noises * noise) * (then.kind === "time" ? slack : 1), beyond = noise > 0 ? Math.abs(moved) / noise : Infinity;
  const verdict = !Number.isFinite(moved) ? "worse" : moved > Math.log1p(allowed) ? "worse" : Math.abs(moved) <= still ? "still"
    : moved < -Math.log1p(allowed) ? "better" : "moved";
  return { name, kind: then.kind, then: then.value, now: now.value, ratio, noise, beyond, allowed, verdict };
}

// What moved beside the committed figures {figures: {name: {value, noise, kind}}}: {moved: [...], missing: names that
// were not measured, added: names that are not committed}.
export function compared(committed, found, slack = 1) {
  const names = Object.keys(committed.figures);
  return { moved: names.filter((n) => found[n]).map((n) => movement(n, committed.figures[n], found[n], slack)),
    missing: names.filter((n) => !found[n]), added: Object.keys(found).filter((n) => !committed.figures[n]) };
}

export function sentence(m) {
  const noise = m.noise < 5e-4 ? "no noise by seeds" : `${m.beyond.toPrecision(2)} times its noise of ${(100 * m.noise).toPrecision(2)} %`;
  const allowed = Number.isFinite(m.allowed) ? `allowed +${(100 * m.allowed).toPrecision(3)} %` : "not judged";
  return `${m.verdict}: ${m.name}: ${m.then.toPrecision(4)} to ${m.now.toPrecision(4)}, ${percent(m.ratio)} (${allowed}; ${noise})`;
}

export function read(path, mode) {
  return existsSync(path) ? JSON.parse(readFileSync(path, "utf8"))[mode] ?? null : null;
}

// Says what moved; true when nothing got worse than is allowed. all: whether every committed figure must be there;
// slack: how many times as far times may go; Infinity: they are only said.
export function judge(committed, lines, all, say, slack) {
  const result = compared(committed, figuresOf(lines), slack), of = (verdict) => result.moved.filter((m) => m.verdict === verdict);
  for (const m of [...of("worse"), ...of("better"), ...of("moved")]) say(sentence(m));
  if (all) for (const name of result.missing) say(`missing: ${name} was not measured`);
  if (all && result.added.length > 0) say(`${result.added.length} figures are not committed yet`);
  say(`gate: ${result.moved.length} figures: ${of("still").length} as they were, ${of("moved").length} moved within what is allowed, ` +
    `${of("better").length} better, ${of("worse").length} worse`);
  return { ...result, ok: of("worse").length === 0 && !(all && result.missing.length > 0) };
}

// Writes the figures of several runs of a mode: values of the first, noise over all of them. Where the runs were of
// some parts only, all other figures stay.
export function accept(path, mode, runs, about, whole = true) {
  const all = existsSync(path) ? JSON.parse(readFileSync(path, "utf8")) : {}, found = runs.map(figuresOf), figures = {};
  for (const [name, { value, kind }] of Object.entries(found[0])) {
    const logs = found.map((f) => Math.log(f[name]?.value)).filter(Number.isFinite), middle = logs.reduce((a, b) => a + b, 0) / logs.length;
    const noise = logs.length > 1 ? Math.sqrt(logs.reduce((sum, v) => sum + (v - middle) ** 2, 0) / (logs.length - 1)) : 0;
    figures[name] = { value: Number(value.toPrecision(9)), noise: Number(noise.toPrecision(3)), kind };
  }
  // A figure a line: what was accepted is to be read in a diff.
  const text = (m) => `{\n${Object.entries(m).map(([k, v]) => k === "figures"
    ? `  "figures": {\n${Object.entries(v).map(([n, f]) => `   ${JSON.stringify(n)}: ${JSON.stringify(f)}`).join(",\n")}\n  }`
    : `  ${JSON.stringify(k)}: ${JSON.stringify(v)}`).join(",\n")}\n }`;
  const accepted = whole || !all[mode] ? { ...about, runs: runs.length, figures } : { ...all[mode], figures: { ...all[mode].figures, ...figures } };
  const next = { ...all, [mode]: accepted };
  writeFileSync(path, `{\n${Object.entries(next).map(([k, m]) => ` ${JSON.stringify(k)}: ${text(m)}`).join(",\n")}\n}\n`);
}

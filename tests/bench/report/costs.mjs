// The report's sections of costs: how they grow, and what skipping saves.
import { writeFileSync } from "node:fs";
import { ofPart, pixelBytes, scaling } from "../judged.mjs";
import { median } from "../parts/runs.mjs";
import { percent, savings, seconds, stages } from "../plot/bars.mjs";
import { lines } from "../plot/lines.mjs";
import { bytes, count, details, escape, number, plots, table, times, verdict } from "./html.mjs";

const kept = (o, name, svg) => {
  if (svg) writeFileSync(`${o.out}/report/plots/${name}.svg`, svg);
  return svg;
};
const wallCells = ({ wall }) => [seconds(wall.tiles), seconds(wall.drawn_late), seconds(wall.after_last_tile), seconds(wall.total)];
const WALL = ["wall: to the last tile", "from there: drawn", "files stored", "all"];

function farms(o, all) {
  const found = scaling(all), first = found[0];
  if (!first) return "";
  const plot = lines({ title: "Wall time with workers of one thread", xLabel: "workers", yLabel: "wall seconds a frame", xTicks: found.map((l) => l.workers),
    series: [{ name: "measured", points: found.map((l) => [l.workers, l.wall_s]) }, { name: "ideal", points: found.map((l) => [l.workers, first.wall_s * first.workers / l.workers]) }] });
  return `<h3>Workers</h3><p>${escape(first.about)}, ${first.height_px} lines, on ${o.cores} cores; the coordinator, which filters and encodes, takes its share of them. Medians of ${first.runs} frames.</p>
${plots(kept(o, "workers", plot))}${table("Wall time by number of workers", ["workers", "speed-up", ...WALL, "after the last tile, of all", "CPU s"],
    found.map((l) => [l.workers, times(l.speedup), ...wallCells(l), percent(l.wall.after_last_tile / l.wall.frame), number(l.cpu_s.total)]))}`;
}

function resolutions(o, all) {
  const found = ofPart(all, "resolution").sort((a, b) => a.height - b.height), kinds = [...new Set(found.map((l) => l.kind))];
  if (found.length === 0) return "";
  const series = (y) => kinds.map((name) => ({ name, points: found.filter((l) => l.kind === name).map((l) => [l.height, y(l)]) })), xTicks = [...new Set(found.map((l) => l.height))];
  const common = { xLabel: "lines of a 16:9 picture", xTicks }, largest = kinds.map((k) => found.filter((l) => l.kind === k).at(-1));
  const about = kinds.map((k) => `<em>${escape(k)}</em>: ${escape(found.find((l) => l.kind === k).about)}`).join("; ");
  return `<h3>Resolution</h3><p>The Cornell box at 9 samples. ${about}.</p>${plots(
    kept(o, "resolution-cpu", lines({ title: "CPU time against resolution", yLabel: "CPU seconds a frame", series: series((l) => l.cpu_s.total), ...common })),
    kept(o, "resolution-pixel", lines({ title: "CPU time a pixel", yLabel: "CPU microseconds a pixel", yLog: false, series: series((l) => l.cpu_s.total / l.megapixels), ...common })),
    kept(o, "resolution-memory", lines({ title: "Peak memory of the coordinator", yLabel: "MB", yLog: false, series: series((l) => l.peak_rss_bytes.server / 1e6), ...common })),
    kept(o, "resolution-stages", stages(`CPU time by stage, ${Math.max(...found.map((l) => l.height))} lines`, largest.map((l) => ({ name: `${l.kind}, ${l.height}`, cpu_s: l.cpu_s })))))}
${table("Cost by resolution", ["kind", "picture", "CPU s", "CPU µs a pixel", ...WALL, "after the last tile, of all", "bytes a pixel", "peak memory: coordinator", "worker"],
    found.map((l) => [l.kind, `${l.width}×${l.height}`, number(l.cpu_s.total), number(l.cpu_s.total / l.megapixels), ...wallCells(l), percent(l.wall.after_last_tile / l.wall.frame),
      number(pixelBytes(l)), bytes(l.peak_rss_bytes.server), bytes(l.peak_rss_bytes.worker)]))}`;
}

function hills(o, all) {
  const found = ofPart(all, "triangles").sort((a, b) => a.triangles - b.triangles);
  if (found.length === 0) return "";
  const series = [["import", (l) => l.cpu_s.import], ["BVH", (l) => l.cpu_s.build], ["trace", (l) => l.cpu_s.trace]].map(([name, y]) => ({ name, points: found.map((l) => [l.triangles, y(l)]) }));
  return `<h3>Triangles</h3><p>The same hills in more and more triangles, ${found[0].side_px}×${found[0].side_px} pixels, soft shadows and one bounce. Import happens once a scene, the BVH once a worker. By default there is one worker of all cores; apart: as many workers of one thread.</p>
${plots(kept(o, "triangles-cpu", lines({ title: "CPU time against triangles", xLabel: "triangles", yLabel: "CPU seconds", series })),
    kept(o, "triangles-memory", lines({ title: "Peak memory of a worker", xLabel: "triangles", yLabel: "MB", yLog: false, series: [{ name: "worker", points: found.map((l) => [l.triangles, l.peak_rss_bytes.worker / 1e6]) }] })))}
${table("Cost by triangles", ["triangles", "import CPU", "BVH CPU", "trace CPU", "wall", "peak memory: worker", "coordinator", "apart: BVH CPU", "wall over that of one worker", "peak memory: workers"],
    found.map((l) => [l.triangles.toLocaleString("en"), seconds(l.cpu_s.import), seconds(l.cpu_s.build), seconds(l.cpu_s.trace), seconds(l.wall.total), bytes(l.peak_rss_bytes.worker), bytes(l.peak_rss_bytes.server),
      ...(l.apart ? [seconds(l.apart.cpu_s.build), times(l.apart.wall.total / l.wall.total), bytes(l.apart.workers * l.apart.peak_rss_bytes.worker)] : ["", "", ""])]))}`;
}

function late(all) {
  const found = ofPart(all, "overlap");
  if (found.length === 0) return "";
  return `<h3>After the last tile</h3><p>Decoding, filtering and encoding overlap with tracing: what is left of a frame's wall time when its last tile has come. Medians of ${found[0].runs} frames; the least of them in the last column.</p>
${table("After the last tile", ["kind", "picture", ...WALL, "after the last tile, of the frame", "least"],
    found.map((l) => [`${escape(l.kind)}: ${escape(l.about)}`, `${l.width}×${l.height}`, ...wallCells(l), percent(median(l.late)), percent(Math.min(...l.late))]))}`;
}

const LINK_NAMES = { unix: "Unix socket", tcp: "TCP, in the clear", sealed: "TCP, TLS 1.3 under a key" };

function wires(all) {
  const found = ofPart(all, "links");
  if (found.length === 0) return "";
  return `<h3>Links</h3><p>The same frames, ${found[0].width}×${found[0].height}, by workers on this machine over three kinds of links, in turn. CPU times are the least of ${found[0].runs} frames; the coordinator's loop reads and writes the links.</p>
${table("Cost of links", ["kind", "link", "bytes", "CPU s", "of it the coordinator's loop", "CPU over Unix", "loop over Unix", "wall over Unix"],
    found.map((l) => [escape(l.kind), LINK_NAMES[l.link_kind], bytes(l.link.received_bytes + l.link.sent_bytes), number(l.cpu_min_s.total), number(l.cpu_min_s.coordinate), times(l.over_unix.cpu), times(l.over_unix.coordinate), times(l.over_unix.wall)]))}`;
}

export function costSection(o, all) {
  const html = [farms(o, all), resolutions(o, all), hills(o, all), late(all), wires(all)].join("\n");
  return html.trim() ? { id: "costs", title: "What frames cost as they grow", html } : null;
}

// A tenth of a percent is rounding.
const saved = (need, spare) => need > 0 ? Math.abs(1 - spare / need) < 2e-3 ? "0 %" : percent(1 - spare / need) : "–";

export function skipSection(o, all) {
  const found = ofPart(all, "skips");
  if (found.length === 0) return null;
  const plot = savings("What each frame takes, where something is needed and where it is not", found.map((l) => ({ name: `${l.skip}: ${l.name}`,
    pairs: [["rays", l.need.rays, l.spare.rays, count], ["bytes sent by workers", l.need.bytes, l.spare.bytes, bytes], ["CPU time", l.need.cpu_s, l.spare.cpu_s, seconds]] })));
  const counters = (l) => Object.entries(l.frames.spare.skipped).filter(([name, n]) => n > (l.frames.need.skipped[name] ?? 0)).map(([name, n]) => `${escape(name)} ${n.toLocaleString("en")}`).join(", ");
  return { id: "skips", title: "What is not needed is not done", html: `<p>Pairs of frames, ${found[0].side_px}×${found[0].side_px} pixels, that differ in one need. CPU time is that of all processes without the file's encoding, median of ${found[0].frames.need.runs}.
That the skip is what saved it is asserted on counters and on the plan, and fails the bench when it does not hold.</p>${plots(kept(o, "skips", plot))}
${table("Savings by kind of skip", ["skip", "needed, and not", "rays saved", "bytes saved", "CPU time saved", "asserted"],
    found.map((l) => [`${escape(l.skip)}: ${escape(l.name)}`, escape(l.about), saved(l.need.rays, l.spare.rays), saved(l.need.bytes, l.spare.bytes), saved(l.need.cpu_s, l.spare.cpu_s),
      verdict(l.holds, l.holds ? "holds" : l.wrong.join("; "))]), [1])}
${details("Counters that are larger where the need is not", table("Counters of skipped work", ["skip", "counters"], found.map((l) => [`${escape(l.skip)}: ${escape(l.name)}`, counters(l) || "the plan alone tells"]), [1]))}` };
}

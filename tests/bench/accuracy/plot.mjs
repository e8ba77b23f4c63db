// Plots as SVG text: lines over two logarithmic axes, and bars of shares.

const WIDTH = 520, HEIGHT = 360, LEFT = 62, RIGHT = 14, TOP = 30, BOTTOM = 46;
export const COLORS = { average: "#6b7280", axis_aligned: "#d97706", sheared: "#2563eb", sheared_4d: "#059669",
  constant: "#d97706", linear: "#059669", blend: "#9333ea", auto: "#111827", paths: "#0891b2", adaptive: "#be185d" };
const STAGES = ["import", "build", "trace", "pack", "decode", "reconstruct", "shadow", "indirect", "glossy", "lens_light", "lens", "encode", "coordinate", "other"];
const STAGE_COLORS = ["#cbd5e1", "#94a3b8", "#60a5fa", "#a5b4fc", "#c4b5fd", "#fca5a5", "#ef4444", "#f97316", "#be185d", "#0d9488", "#4f46e5", "#86efac", "#fcd34d", "#e5e7eb"];

const escape = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const text = (x, y, words, more = "") => `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" ${more}>${escape(words)}</text>`;
const line = (x0, y0, x1, y1, more) =>
  `<line x1="${x0.toFixed(1)}" y1="${y0.toFixed(1)}" x2="${x1.toFixed(1)}" y2="${y1.toFixed(1)}" ${more}/>`;

function frame(title, body, height = HEIGHT) {
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${height}" width="${WIDTH}" height="${height}" ` +
    `font-family="system-ui,sans-serif" font-size="11" role="img"><title>${escape(title)}</title>` +
    `<rect width="${WIDTH}" height="${height}" fill="#fff"/>` +
    text(LEFT, 18, title, 'font-size="13" font-weight="600"') + body + "</svg>\n";
}

// A logarithmic axis over the values: its range, and ticks of 1, 2, 5 times powers of ten.
function axis(values, from, to) {
  const low = Math.log10(Math.min(...values)) - 0.05, high = Math.log10(Math.max(...values)) + 0.05;
  const at = (v) => from + (Math.log10(v) - low) / (high - low) * (to - from);
  const ticks = [];
  for (let e = Math.floor(low); e <= Math.ceil(high); e++)
    for (const m of high - low > 2.5 ? [1] : [1, 2, 5]) {
      const v = m * 10 ** e;
      if (Math.log10(v) >= low && Math.log10(v) <= high) ticks.push(v);
    }
  return { at, ticks };
}
const short = (v) => v >= 1e4 || v < 1e-3 ? v.toExponential(0) : String(Number(v.toPrecision(v < 1 ? 2 : 4)));

// series: [{name, points: [[x, y], ...]}]; slope: of a dashed line through the first series' start.
export function logLog(title, xLabel, yLabel, series, { slope, xTicks } = {}) {
  const all = series.flatMap((s) => s.points).filter(([x, y]) => x > 0 && y > 0);
  if (all.length === 0) return "";
  const right = WIDTH - RIGHT, bottom = HEIGHT - BOTTOM;
  const x = axis(all.map((p) => p[0]), LEFT, right), y = axis(all.map((p) => p[1]), bottom, TOP);
  const parts = [];
  for (const v of xTicks ?? x.ticks)
    parts.push(line(x.at(v), TOP, x.at(v), bottom, 'stroke="#e5e7eb"'), text(x.at(v), bottom + 15, short(v), 'text-anchor="middle"'));
  for (const v of y.ticks)
    parts.push(line(LEFT, y.at(v), right, y.at(v), 'stroke="#e5e7eb"'), text(LEFT - 6, y.at(v) + 4, short(v), 'text-anchor="end"'));
  parts.push(`<rect x="${LEFT}" y="${TOP}" width="${right - LEFT}" height="${bottom - TOP}" fill="none" stroke="#9ca3af"/>`);
  parts.push(text((LEFT + right) / 2, HEIGHT - 10, xLabel, 'text-anchor="middle"'));
  parts.push(text(0, 0, yLabel, `text-anchor="middle" transform="translate(14 ${(TOP + bottom) / 2}) rotate(-90)"`));
  if (slope && series[0].points.length > 1) {
    const [x0, y0] = series[0].points[0], [x1] = series[0].points.at(-1);
    parts.push(line(x.at(x0), y.at(y0), x.at(x1), y.at(y0 * (x1 / x0) ** slope), 'stroke="#9ca3af" stroke-dasharray="5 4" clip-path="url(#box)"'));
    parts.push(`<clipPath id="box"><rect x="${LEFT}" y="${TOP}" width="${right - LEFT}" height="${bottom - TOP}"/></clipPath>`);
  }
  series.forEach(({ name, points }, i) => {
    const color = COLORS[name] ?? "#111";
    parts.push(`<polyline fill="none" stroke="${color}" stroke-width="1.8" points="${points.map(([a, b]) =>
      `${x.at(a).toFixed(1)},${y.at(b).toFixed(1)}`).join(" ")}"/>`);
    for (const [a, b] of points) parts.push(`<circle cx="${x.at(a).toFixed(1)}" cy="${y.at(b).toFixed(1)}" r="2.6" fill="${color}"/>`);
    parts.push(line(right - 118, TOP + 14 + 15 * i, right - 98, TOP + 14 + 15 * i, `stroke="${color}" stroke-width="1.8"`),
      text(right - 92, TOP + 18 + 15 * i, name));
  });
  if (slope) parts.push(text(right - 92, TOP + 18 + 15 * series.length, `slope ${slope}`, 'fill="#6b7280"'));
  return frame(title, parts.join("\n"));
}

// bars: [{name, cpu_s}], each drawn as seconds of its stages one after another.
export function stages(title, bars) {
  const known = (cpu) => STAGES.slice(0, -1).map((s) => cpu[s] ?? 0);
  const parts = [], most = Math.max(...bars.map((b) => b.cpu_s.total)), high = 22;
  const scale = (WIDTH - 150 - RIGHT - 50) / most;
  bars.forEach(({ name, cpu_s }, row) => {
    const seconds = known(cpu_s), top = TOP + row * high;
    seconds.push(Math.max(0, cpu_s.total - seconds.reduce((a, b) => a + b, 0)));
    let at = 150;
    seconds.forEach((s, i) => {
      parts.push(`<rect x="${at.toFixed(1)}" y="${top}" width="${(s * scale).toFixed(2)}" height="${high - 6}" fill="${STAGE_COLORS[i]}">` +
        `<title>${STAGES[i]} ${s.toFixed(3)} s</title></rect>`);
      at += s * scale;
    });
    parts.push(text(144, top + 12, name, 'text-anchor="end"'), text(at + 5, top + 12, `${cpu_s.total.toFixed(2)} s`));
  });
  const below = TOP + bars.length * high + 14;
  STAGES.forEach((stage, i) => {
    const x = 20 + i % 5 * 98, y = below + Math.floor(i / 5) * 17;
    parts.push(`<rect x="${x}" y="${y - 9}" width="10" height="10" fill="${STAGE_COLORS[i]}"/>`, text(x + 15, y, stage));
  });
  return frame(title, parts.join("\n"), below + 17 * Math.ceil(STAGES.length / 5));
}

// Bars that lie: seconds or shares of stages one after another, and plain ones.
import { STAGES, stagesOf } from "./colors.mjs";
import { escape, frame, line, rect, text } from "./svg.mjs";

const WIDTH = 680, TOP = 40, ROW = 26, BAR = 19;
const seconds = (s) => s >= 100 ? `${s.toFixed(0)} s` : s >= 1 ? `${s.toFixed(2)} s` : `${(1000 * s).toFixed(s >= 0.01 ? 0 : 1)} ms`;
const percent = (share) => `${share < 0 ? "−" : ""}${(100 * Math.abs(share)).toFixed(Math.abs(share) < 0.0995 ? 1 : 0)} %`;
// A character takes about this much.
const CHARACTER_PX = 6.4;

function legend(y) {
  const parts = [];
  let x = 14;
  for (const { name, color } of STAGES) {
    parts.push(rect(x, y - 10, 11, 11, `fill="${color}" stroke="#767676" stroke-width="0.5"`), text(x + 16, y, name, 'font-size="11"'));
    x += 26 + CHARACTER_PX * name.length;
  }
  return parts;
}

// bars: [{name, cpu_s}]; shares: each bar as long as the next, for what parts it has.
export function stages(title, bars, { shares = true } = {}) {
  const known = bars.map(({ name, cpu_s }) => ({ name, total: cpu_s.total, parts: stagesOf(cpu_s) })).filter((b) => b.total > 0);
  if (known.length === 0) return "";
  const left = 20 + CHARACTER_PX * Math.max(...known.map((b) => b.name.length)), room = WIDTH - left - 76;
  const most = Math.max(...known.map((b) => b.total)), parts = [];
  known.forEach(({ name, total, parts: stagesHere }, row) => {
    const y = TOP + row * ROW, scale = room / (shares ? total : most);
    let x = left;
    parts.push(text(left - 8, y + 14, name, 'text-anchor="end"'));
    for (const { name: stage, seconds: s, color, ink } of stagesHere.filter((p) => p.seconds > 0)) {
      const width = s * scale, words = percent(s / total);
      parts.push(rect(x, y, width, BAR, `fill="${color}" stroke="#fff" stroke-width="0.8"`, `<title>${escape(`${name}: ${stage} ${seconds(s)}, ${words}`)}</title>`));
      if (width > CHARACTER_PX * words.length + 4) parts.push(text(x + width / 2, y + 14, words, `text-anchor="middle" font-size="11" fill="${ink}"`));
      x += width;
    }
    parts.push(text(x + 6, y + 14, seconds(total)));
  });
  const below = TOP + known.length * ROW + 20, desc = known.map((b) => `${b.name}: ${b.parts.filter((p) => p.seconds > 0)
    .map((p) => `${p.name} ${percent(p.seconds / b.total)}`).join(", ")} of ${seconds(b.total)}`).join(". ");
  parts.push(...legend(below));
  return frame(title, `Bars of CPU time by stage. ${desc}.`, WIDTH, below + 14, parts.join("\n"));
}

// Pairs of bars: how much something takes with a need and without, as parts of the larger.
//   rows: [{name, pairs: [[label, with, without, unit], ...]}]
export function savings(title, rows) {
  const columns = rows[0]?.pairs.length ?? 0;
  if (columns === 0) return "";
  const left = 20 + CHARACTER_PX * Math.max(...rows.map((r) => r.name.length)), width = (WIDTH + 120 - left) / columns, high = 40, parts = [];
  rows[0].pairs.forEach(([label], c) => parts.push(text(left + c * width, TOP + 8, label, 'font-weight="600"')));
  rows.forEach(({ name, pairs }, r) => {
    const y = TOP + 18 + r * high;
    parts.push(text(left - 8, y + 18, name, 'text-anchor="end"'), line(14, y + high - 5, WIDTH + 106, y + high - 5, 'stroke="#ececec"'));
    pairs.forEach(([, need, spare, show], c) => {
      const x = left + c * width, room = width - 74, most = Math.max(need, spare);
      [[need, "#0060ad"], [spare, "#b35900"]].forEach(([value, color], i) => {
        const long = most > 0 ? value / most * room : 0;
        parts.push(rect(x, y + 2 + 15 * i, Math.max(long, 1), 11, `fill="${color}"`), text(x + Math.max(long, 1) + 5, y + 12 + 15 * i, show(value), 'font-size="11"'));
      });
    });
  });
  const below = TOP + 36 + rows.length * high;
  parts.push(rect(14, below - 10, 11, 11, 'fill="#0060ad"'), text(31, below, "needed"), rect(104, below - 10, 11, 11, 'fill="#b35900"'), text(121, below, "not needed"));
  const desc = rows.map(({ name, pairs }) => `${name}: ${pairs.map(([label, a, b, show]) => `${label} ${show(a)} where needed, ${show(b)} where not`).join(", ")}`);
  return frame(title, `Pairs of bars. ${desc.join(". ")}.`, WIDTH + 120, below + 14, parts.join("\n"));
}

export { percent, seconds };

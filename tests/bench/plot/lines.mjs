// Lines over two axes, each with its name at its right end.
import { linearAxis, logAxis, short, thinned } from "./axis.mjs";
import { lookOf } from "./colors.mjs";
import { frame, line, mark, polyline, rect, text } from "./svg.mjs";

const WIDTH = 560, HEIGHT = 380, LEFT = 66, RIGHT = 112, TOP = 38, BOTTOM = 52, LABEL_PX = 14;
const right = WIDTH - RIGHT, bottom = HEIGHT - BOTTOM;

function axes(x, y, xTicks, yLabel, xLabel) {
  const parts = [];
  for (const v of y.minor) parts.push(line(LEFT, y.at(v), right, y.at(v), 'stroke="#f1f1f1"'));
  for (const v of x.minor) parts.push(line(x.at(v), TOP, x.at(v), bottom, 'stroke="#f1f1f1"'));
  for (const [v, label] of thinned(x.ticks, x.at, xTicks ? 22 : 30)) {
    parts.push(line(x.at(v), TOP, x.at(v), bottom + 4, 'stroke="#d0d0d0"'), text(x.at(v), bottom + 18, label, 'text-anchor="middle"'));
  }
  for (const [v, label] of thinned(y.ticks, y.at, 15))
    parts.push(line(LEFT - 4, y.at(v), right, y.at(v), 'stroke="#d0d0d0"'), text(LEFT - 8, y.at(v) + 4, label, 'text-anchor="end"'));
  parts.push(rect(LEFT, TOP, right - LEFT, bottom - TOP, 'fill="none" stroke="#767676"'));
  parts.push(text((LEFT + right) / 2, HEIGHT - 12, xLabel, 'text-anchor="middle"'));
  parts.push(text(0, 0, yLabel, `text-anchor="middle" transform="translate(16 ${(TOP + bottom) / 2}) rotate(-90)"`));
  return parts;
}

// Places of labels, as near to where they are wanted as they get without covering each other.
function spread(wanted) {
  const order = wanted.map((y, i) => ({ y, i })).sort((a, b) => a.y - b.y), places = [];
  order.forEach((o, k) => { o.place = k === 0 ? o.y : Math.max(o.y, order[k - 1].place + LABEL_PX); });
  // What ran over the lower edge is pushed back.
  for (let k = order.length - 1, limit = bottom + 4; k >= 0; k--, limit -= LABEL_PX) order[k].place = Math.min(order[k].place, limit);
  for (const o of order) places[o.i] = o.place;
  return places;
}

function guideOf({ slope, through: [x0, y0], label }, x, y, span) {
  const [from, to] = span, value = (v) => y0 * (v / x0) ** slope;
  return [line(x.at(from), y.at(value(from)), x.at(to), y.at(value(to)), 'stroke="#8a8a8a" stroke-dasharray="6 4" clip-path="url(#CLIP)"'),
    text(x.at(to) - 4, Math.min(Math.max(y.at(value(to)) - 6, TOP + 12), bottom - 6), label, 'text-anchor="end" fill="#5c5c5c" font-size="11" paint-order="stroke" stroke="#fff" stroke-width="4"')];
}

function describe({ xLabel, yLabel, series }) {
  const said = series.map(({ name, points }) => `${name}: ${points.map(([a, b]) => `${short(a)} → ${short(b)}`).join(", ")}`);
  return `Lines of ${yLabel} over ${xLabel}. ${said.join(". ")}.`;
}

// plot: {title, xLabel, yLabel, series: [{name, points: [[x, y], ...]}] joined as they come, xLog, yLog (both true unless said),
// xTicks: values, guide: {slope, through: [x, y], label}}. "" when there is nothing to draw.
export function lines(plot) {
  const { title, xLabel, yLabel, xLog = true, yLog = true, xTicks, guide } = plot;
  const kept = plot.series.map((s) => ({ ...s, points: s.points.filter(([a, b]) => Number.isFinite(a) && Number.isFinite(b) &&
    (!xLog || a > 0) && (!yLog || b > 0)) })).filter((s) => s.points.length > 0);
  if (kept.length === 0) return "";
  const all = kept.flatMap((s) => s.points), span = [Math.min(...all.map((p) => p[0])), Math.max(...all.map((p) => p[0]))];
  const x = (xLog ? logAxis : linearAxis)(all.map((p) => p[0]), LEFT, right, xTicks);
  const y = (yLog ? logAxis : linearAxis)(all.map((p) => p[1]), bottom, TOP);
  const parts = axes(x, y, xTicks, yLabel, xLabel), clip = `clip-${title.replace(/[^a-z0-9]+/gi, "-").toLowerCase()}`;
  parts.push(`<clipPath id="${clip}">${rect(LEFT, TOP, right - LEFT, bottom - TOP, "")}</clipPath>`);
  if (guide) parts.push(...guideOf(guide, x, y, span).map((s) => s.replace("#CLIP", `#${clip}`)));
  const labels = spread(kept.map((s) => y.at(s.points.at(-1)[1]) + 4));
  kept.forEach(({ name, points }, i) => {
    const { color, mark: kind } = lookOf(name, i), places = points.map(([a, b]) => [x.at(a), y.at(b)]);
    parts.push(polyline(places, `stroke="${color}" stroke-width="2" stroke-linejoin="round"`));
    points.forEach(([a, b], k) => parts.push(mark(kind, ...places[k], color, `${name}: ${short(b)} at ${short(a)}`)));
    const [endX, endY] = places.at(-1);
    parts.push(line(endX + 5, endY, right + 10, labels[i] - 4, `stroke="${color}" stroke-width="0.8" stroke-opacity="0.6"`));
    parts.push(mark(kind, right + 16, labels[i] - 4, color), text(right + 24, labels[i], name, 'font-weight="500"'));
  });
  return frame(title, describe({ xLabel, yLabel, series: kept }), WIDTH, HEIGHT, parts.join("\n"));
}

// The plots of accuracy's pages.
import { stages as stageBars } from "../plot/bars.mjs";
import { lines } from "../plot/lines.mjs";

// series: [{name, points: [[x, y], ...]}]; slope: of a dashed line through the first series' start.
export function logLog(title, xLabel, yLabel, series, { slope, xTicks } = {}) {
  const start = series[0]?.points[0];
  return lines({ title, xLabel, yLabel, series, xTicks,
    guide: slope && series[0].points.length > 1 ? { slope, through: start, label: `slope ${slope}` } : undefined });
}

// bars: [{name, cpu_s}], each drawn as seconds of its stages one after another.
export const stages = (title, bars) => stageBars(title, bars, { shares: false });

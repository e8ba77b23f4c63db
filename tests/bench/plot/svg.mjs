// Plots as SVG text, made here: a frame with a title and a description for those who do not see it, and
// the few shapes that plots are made of.

export const escape = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

const at = (v) => String(Number(v.toFixed(2)));

export const text = (x, y, words, more = "") => `<text x="${at(x)}" y="${at(y)}" ${more}>${escape(words)}</text>`;
export const line = (x0, y0, x1, y1, more) => `<line x1="${at(x0)}" y1="${at(y0)}" x2="${at(x1)}" y2="${at(y1)}" ${more}/>`;
export const rect = (x, y, w, h, more, inside = "") => `<rect x="${at(x)}" y="${at(y)}" width="${at(w)}" height="${at(h)}" ${more}` +
  (inside ? `>${inside}</rect>` : "/>");
export const polyline = (points, more) => `<polyline fill="none" points="${points.map(([x, y]) => `${at(x)},${at(y)}`).join(" ")}" ${more}/>`;

// Marks of one area around a point: what tells series apart besides their colour.
const MARKS = {
  circle: (x, y) => `<circle cx="${at(x)}" cy="${at(y)}" r="3.4"/>`,
  square: (x, y) => rect(x - 3, y - 3, 6, 6, ""),
  diamond: (x, y) => `<path d="M${at(x)} ${at(y - 4.3)}l4.3 4.3l-4.3 4.3l-4.3 -4.3z"/>`,
  triangle: (x, y) => `<path d="M${at(x)} ${at(y - 4.2)}l4.2 7.2h-8.4z"/>`,
  wedge: (x, y) => `<path d="M${at(x)} ${at(y + 4.2)}l4.2 -7.2h-8.4z"/>`,
  cross: (x, y) => `<path d="M${at(x - 3.2)} ${at(y - 3.2)}l6.4 6.4m0 -6.4l-6.4 6.4" fill="none" stroke="currentColor" stroke-width="2"/>`,
  plus: (x, y) => `<path d="M${at(x - 4)} ${at(y)}h8m-4 -4v8" fill="none" stroke="currentColor" stroke-width="2"/>`,
};
export const mark = (kind, x, y, color, tip) => `<g fill="${color}" color="${color}">${tip ? `<title>${escape(tip)}</title>` : ""}${MARKS[kind](x, y)}</g>`;

let count = 0;

// The whole picture. desc: what the plot shows, in words, with its figures.
export function frame(title, desc, width, height, body) {
  const id = `plot-${++count}-${title.replace(/[^a-z0-9]+/gi, "-").toLowerCase()}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" ` +
    `font-family="system-ui,sans-serif" font-size="12" fill="#1a1a1a" role="img" aria-labelledby="${id}-t ${id}-d">\n` +
    `<title id="${id}-t">${escape(title)}</title><desc id="${id}-d">${escape(desc)}</desc>\n` +
    `${rect(0, 0, width, height, 'fill="#fff"')}\n${text(14, 20, title, 'font-size="14" font-weight="600"')}\n${body}\n</svg>\n`;
}

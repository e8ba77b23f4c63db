// Small plots as SVG, each beside a table with the same numbers.
import { make, makeSvg } from "../elements.js";

const ROW = 22, NAME = 118, BAR = 130, VALUE = 92, MOST = 12;

// A figure of bars: rows [[name, value], ...], the longest first.
export class BarPlot {
  constructor(figure, { title, columns, show }) {
    Object.assign(this, { figure, title, show });
    this.plot = makeSvg("svg", { role: "img", class: "plot" });
    this.caption = make("figcaption", {}, title);
    this.body = make("tbody");
    const table = make("table", {}, make("thead", {}, make("tr", {}, ...columns.map((column) => make("th", { scope: "col" }, column)))), this.body);
    figure.replaceChildren(this.caption, this.plot, make("details", {}, make("summary", {}, `${title} as a table`), table));
  }

  draw(rows) {
    const { figure, plot } = this;
    figure.hidden = rows.length === 0;
    const key = JSON.stringify(rows);
    if (rows.length === 0 || key === this.key) return;
    this.key = key;
    const shown = rows.slice(0, MOST), most = shown[0][1];
    plot.setAttribute("viewBox", `0 0 ${NAME + BAR + VALUE} ${shown.length * ROW}`);
    plot.setAttribute("aria-label", `${this.title}: ${shown.map(([name, value]) => `${name} ${this.show(value)}`).join(", ")}`);
    plot.replaceChildren(...shown.flatMap(([name, value], i) => this.bar(name, value, most, i * ROW)));
    this.body.replaceChildren(...rows.map(([name, value]) =>
      make("tr", {}, make("th", { scope: "row" }, name), make("td", {}, this.show(value)))));
  }

  bar(name, value, most, y) {
    const width = Math.max(1, BAR * value / most);
    return [
      makeSvg("text", { x: NAME - 6, y: y + 15, "text-anchor": "end" }, name),
      makeSvg("rect", { x: NAME, y: y + 4, width, height: ROW - 8, rx: 2 }),
      makeSvg("text", { x: NAME + width + 6, y: y + 15 }, this.show(value)),
    ];
  }
}

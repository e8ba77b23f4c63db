// The values of single pixels: the one under the mouse (or the keyboard's own), and pinned ones that
// stay in a list and follow the render.
import { setText } from "../elements.js";
import { short } from "./value_overlay.js";

const PINS = 8;

export class Probe {
  // `readout` shows the pixel pointed at, `list` the pinned ones.
  constructor({ readout, list }, onChange) {
    this.readout = readout;
    this.list = list;
    this.onChange = onChange;
    this.point = null; // {x, y}, whole pixels of the picture
    this.byKeys = false;
    this.more = () => ""; // what else there is to say of a pixel
    this.pins = [];
  }

  clear() {
    this.point = null;
    this.pins = [];
    this.rows();
  }

  set(point, byKeys = false) {
    this.point = point && { x: Math.floor(point.x), y: Math.floor(point.y) };
    this.byKeys = byKeys && point !== null;
    this.onChange();
  }

  // One step by key; begins where the mouse was if that is in sight, else in its middle.
  step(dx, dy, viewport) {
    const { x0, y0, x1, y1 } = viewport.visible(), { width, height } = viewport.picture;
    const p = this.point, seen = p && p.x >= x0 && p.x < x1 && p.y >= y0 && p.y < y1;
    const at = seen ? p : { x: (x0 + x1) >> 1, y: (y0 + y1) >> 1 };
    const inside = (v, most) => Math.min(most - 1, Math.max(0, v));
    this.set({ x: inside(at.x + dx, width), y: inside(at.y + dy, height) }, true);
  }

  pin() {
    const { point } = this;
    if (!point || this.pins.some(({ x, y }) => x === point.x && y === point.y)) return;
    this.pins.push({ ...point });
    if (this.pins.length > PINS) this.pins.shift();
    this.rows();
    this.onChange();
  }

  unpin(index) {
    this.pins.splice(index, 1);
    this.rows();
    (this.list.querySelectorAll("button")[Math.min(index, this.pins.length - 1)] ?? this.readout.closest("section")?.querySelector("h3"))?.focus?.();
    this.onChange();
  }

  rows() {
    this.list.replaceChildren(...this.pins.map(({ x, y }, i) => {
      const row = document.createElement("li"), text = document.createElement("span");
      const remove = document.createElement("button");
      remove.type = "button";
      remove.textContent = "Remove";
      remove.setAttribute("aria-label", `Remove probe ${i + 1} at ${x}, ${y}`);
      remove.addEventListener("click", () => this.unpin(this.pins.findIndex((pin) => pin.x === x && pin.y === y)));
      row.append(text, remove);
      return row;
    }));
    this.list.hidden = this.pins.length === 0;
  }

  marks() {
    const marks = this.pins.map(({ x, y }, i) => ({ x, y, name: String(i + 1) }));
    return this.byKeys && this.point ? [...marks, { ...this.point, name: "" }] : marks;
  }

  // What is there: the layer's values and, where two are compared, the other's.
  describe({ x, y }, first, other, scalar) {
    const one = (image) => {
      const values = image?.at(x, y);
      if (!values) return "nothing yet";
      const digits = image.isFloat() ? 9 : 5; // as many as tell any two numbers of the feed apart
      const alpha = image.alphaAt(x, y);
      return (scalar ? values.slice(0, 1) : values).map((v) => short(v, digits)).join("  ") + (alpha === null ? "" : `  A ${short(alpha, digits)}`);
    };
    return `${x}, ${y}: ${one(first)}${other ? ` | ${one(other)}` : ""}${this.more({ x, y })}`;
  }

  show(first, other, scalar) {
    const { point } = this;
    const inside = point && point.x >= 0 && point.y >= 0 && point.x < first.width && point.y < first.height;
    setText(this.readout, inside ? this.describe(point, first, other, scalar) : "Point at the picture, or press Shift and an arrow key.");
    this.pins.forEach((pin, i) => {
      setText(this.list.children[i].firstElementChild, `${i + 1}. ${this.describe(pin, first, other, scalar)}`);
    });
  }
}

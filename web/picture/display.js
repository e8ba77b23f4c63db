// How numbers become colours: what the person chose, kept by layer where it depends on the layer.

const SHOWN_AS = { normal: "vector", depth: "colour", samples: "colour", filter_width: "colour", error: "colour",
                   visibility: "colour", id: "colour", slope_min: "sign", slope_max: "sign" };
const RANGE_SAMPLES = 40000;
// Layers of light share the job's exposure and view. All others, files of the person's too, have
// colours that are no light, or numbers: a view would only falsify them.
const LIGHT = new Set(["beauty", "direct", "indirect", "emission", "diffuse_direct", "diffuse_indirect",
  "composite", "overlay", "backplate"]);
const PLAIN = { exposure: 0, curve: "linear" };

export class Display {
  // `controls`: the page's elements by name. `onChange()` after every change.
  constructor(controls, onChange) {
    this.at = controls;
    this.onChange = onChange;
    this.byLayer = new Map();
    Object.assign(this, { gamma: 1, behind: "black", dither: true, clipMarks: false });
    this.asked = { exposure: 0, curve: "agx" }; // by the job
    this.tones = { light: { ...this.asked }, plain: { ...PLAIN } };
    this.setLayer("beauty");
    for (const name of ["exposure", "gamma"])
      controls[name].addEventListener("input", () => this.set(name, Number(controls[name].value)));
    for (const name of ["low", "high"])
      controls[name].addEventListener("change", () => this.setRange(name, Number(controls[name].value)));
    controls.curve.addEventListener("change", () => this.set("curve", controls.curve.value));
    controls.behind.addEventListener("change", () => this.set("behind", controls.behind.value));
    controls.shownAs.addEventListener("change", () => this.set("shownAs", controls.shownAs.value));
    for (const name of ["auto", "logarithmic", "dither", "clipMarks"])
      controls[name].addEventListener("change", () => this.set(name, controls[name].checked));
    controls.reset.addEventListener("click", () => this.reset());
  }

  setLayer(layer) {
    this.layer = layer;
    const own = this.byLayer.get(layer) 
      ?? { shownAs: SHOWN_AS[layer] ?? "picture", low: 0, high: 1, auto: true, logarithmic: layer === "error" };
    this.byLayer.set(layer, own);
    Object.assign(this, own, this.tone);
    this.show();
  }

  get isLight() { return LIGHT.has(this.layer); }
  get tone() { return this.tones[this.isLight ? "light" : "plain"]; }

  // How a job is seen, where it is shown first: {view, exposure} of its document.
  ask({ view = "agx", exposure = 0 }) {
    this.asked = { exposure, curve: view };
    this.tones.light = { ...this.asked };
    Object.assign(this, this.tone);
    this.show();
    this.onChange();
  }

  set(name, value) {
    if (name === "curve" && !this.isLight) return;
    this[name] = value;
    if (name in this.tone) this.tone[name] = value;
    const own = this.byLayer.get(this.layer);
    if (name in own) own[name] = value;
    if (this.logarithmic) this.keepPositive();
    this.show();
    this.onChange();
  }

  setRange(name, value) {
    if (!Number.isFinite(value)) { this.show(); return; }
    this.set("auto", false);
    this.set(name, value);
  }

  reset() {
    this.gamma = 1;
    Object.assign(this, Object.assign(this.tone, this.isLight ? this.asked : PLAIN));
    this.show();
    this.onChange();
  }

  step(name, by) {
    const { min, max } = this.at[name];
    this.set(name, Math.min(Number(max), Math.max(Number(min), Math.round((this[name] + by) * 100) / 100)));
  }

  next(name, values) { this.set(name, values[(values.indexOf(this[name]) + 1) % values.length]); }

  // The range of false colours from what is there: nearly all of it, so that a spark does not
  // darken the rest.
  measure(image) {
    if (!this.auto || (this.shownAs !== "colour" && this.shownAs !== "sign") || !image.numbers) return;
    const values = [];
    const step = Math.max(1, Math.floor(Math.sqrt(image.width * image.height / RANGE_SAMPLES)));
    image.each({ x0: 0, y0: 0, x1: image.width, y1: image.height }, step, (r, g, b) => {
      const v = 0.2126 * r + 0.7152 * g + 0.0722 * b;
      if (Number.isFinite(v)) values.push(this.shownAs === "sign" ? Math.abs(v) : v);
    });
    if (values.length === 0) return;
    values.sort((a, b) => a - b);
    const low = values[Math.floor(0.005 * (values.length - 1))];
    const high = values[Math.ceil(0.995 * (values.length - 1))];
    const own = this.byLayer.get(this.layer);
    this.low = own.low = low;
    this.high = own.high = high > low ? high : low + 1;
    if (this.logarithmic) this.keepPositive();
    this.show();
  }

  // Logarithms need a range above zero: four decades at most, that the rest does not go into the
  // smallest of numbers.
  keepPositive() {
    const own = this.byLayer.get(this.layer);
    if (!(this.high > 0)) this.high = own.high = 1;
    if (!(this.low >= this.high * 1e-4 && this.low < this.high)) this.low = own.low = this.high * 1e-4;
  }

  show() {
    const { at } = this;
    for (const name of ["exposure", "gamma", "curve", "behind", "shownAs"]) at[name].value = String(this[name]);
    for (const name of ["auto", "logarithmic", "dither", "clipMarks"]) at[name].checked = this[name];
    for (const name of ["low", "high"])
      if (document.activeElement !== at[name]) at[name].value = String(Number(this[name].toPrecision(3)));
    at.exposureText.textContent = `${this.exposure > 0 ? "+" : ""}${this.exposure} EV`;
    at.gammaText.textContent = this.gamma.toFixed(2);
    at.tone.hidden = this.shownAs !== "picture";
    at.range.hidden = this.shownAs !== "colour" && this.shownAs !== "sign";
    at.curve.disabled = !this.isLight;
    at.low.disabled = this.shownAs === "sign";
    at.logarithmic.disabled = this.shownAs === "sign";
  }
}

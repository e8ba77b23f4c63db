// The plain controls of the form: one function a kind of field. Each makes its elements, reads its
// value from the form's document and writes every change back.
import { make } from "../elements.js";

const idOf = (pointer) => `f${pointer.replace(/[^A-Za-z0-9_]/g, "-")}`;
const limits = ({ min, max, above, unit, otherwise }) => {
  const low = above !== undefined ? `above ${above}` : min !== undefined && Math.abs(min) < 1e15 ? `${min}` : "";
  const high = max !== undefined && max < 1e12 ? `${max}` : "";
  const range = low && high ? (above !== undefined ? `${low}, to ${high}` : `${low} to ${high}`) : low && (above !== undefined ? low : `from ${low}`);
  return [range && `${range}${unit ? ` ${unit}` : ""}`, otherwise !== undefined && `default ${otherwise}`].filter(Boolean).join("; ");
};

// A number as typed: what is none is kept as it is, for the server to name.
export const parseNumber = (text) => text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : text.trim();
const show = (value) => value === undefined || value === null ? "" : typeof value === "string" ? value : JSON.stringify(value);

function misfit(spec, value) {
  if (value === undefined || value === "") return null;
  if (typeof value !== "number") return `${JSON.stringify(value)} is not a number`;
  if (spec.kind === "integer" && !Number.isInteger(value)) return `${value} is not a whole number`;
  if (value < spec.min) return `${value} is below ${spec.min}`;
  if (value > spec.max) return `${value} is above ${spec.max}`;
  if (value <= spec.above) return `${value} is not above ${spec.above}`;
  return null;
}

// A labelled control with its hint and the place of its fault; known to the form by its pointer.
export function field(form, pointer, label, control, { hint = "", check = null, extra = [] } = {}) {
  const id = idOf(pointer);
  const fault = make("p", { class: "fault", id: `${id}-fault`, hidden: true });
  control.id = id;
  control.setAttribute("aria-describedby", [hint && `${id}-hint`, `${id}-fault`].filter(Boolean).join(" "));
  form.register(pointer, { control, label, fault, check });
  return make("div", { class: "field" }, make("label", { for: id }, label), control, ...extra,
    hint ? make("p", { class: "hint", id: `${id}-hint` }, hint) : null, fault);
}

// Several controls under one name.
export function group(form, pointer, label, controls, hint = "") {
  const id = idOf(pointer);
  const fault = make("p", { class: "fault", id: `${id}-fault`, hidden: true });
  const set = make("fieldset", { class: "field group", id, tabindex: "-1", "aria-describedby": `${id}-fault` },
    make("legend", {}, label), ...controls, hint ? make("p", { class: "hint" }, hint) : null, fault);
  form.register(pointer, { control: set, label, fault, check: null });
  return set;
}

function number(form, spec, pointer) {
  const input = make("input", { type: "text", inputmode: "decimal", autocomplete: "off", placeholder: spec.otherwise ?? "" });
  input.value = show(form.get(pointer));
  input.addEventListener("input", () => {
    if (input.value.trim() === "") form.remove(pointer);
    else form.set(pointer, parseNumber(input.value));
  });
  return field(form, pointer, spec.unit ? `${spec.label} (${spec.unit})` : spec.label, input,
    { hint: limits(spec), check: () => misfit(spec, form.get(pointer)) });
}

function written(form, spec, pointer, input) {
  input.value = show(form.get(pointer));
  input.addEventListener("input", () => {
    if (input.value === "") form.remove(pointer);
    else form.set(pointer, input.value);
  });
  return field(form, pointer, spec.label, input, { hint: spec.hint ?? "" });
}

// A name, or nothing; a text has lines.
const word = (form, spec, pointer) =>
  written(form, spec, pointer, make("input", { type: "text", autocomplete: "off", spellcheck: "false", maxlength: spec.longest }));
const lines = (form, spec, pointer) => written(form, spec, pointer, make("textarea", { rows: 2, maxlength: spec.longest }));

// Where a list may have a ground among its names, it is written as "ground 0".
const sayWord = (one) => one?.ground ? `ground ${one.ground.height}` : String(one);
function readWord(word, grounds) {
  const [, height] = grounds ? /^ground (-?[0-9.]+)$/.exec(word) ?? [] : [];
  return height === undefined ? word : { ground: { height: Number(height) } };
}

function words(form, spec, pointer) {
  const input = make("input", { type: "text", autocomplete: "off", spellcheck: "false" });
  const value = form.get(pointer);
  input.value = Array.isArray(value) ? value.map(sayWord).join(", ") : show(value);
  input.addEventListener("input", () => {
    const all = input.value.split(",").map((one) => one.trim()).filter(Boolean);
    if (all.length === 0) form.remove(pointer);
    else form.set(pointer, all.map((one) => readWord(one, spec.grounds)));
  });
  return field(form, pointer, spec.label, input, { hint: spec.hint ?? "" });
}

function choice(form, spec, pointer) {
  const value = form.get(pointer) ?? spec.otherwise;
  const names = spec.of.includes(value) ? spec.of : [...spec.of, value]; // written by hand: the server will say
  const select = make("select", {}, ...names.map((name) =>
    make("option", { value: show(name), selected: name === value }, show(name).replaceAll("_", " "))));
  select.addEventListener("change", () => {
    const chosen = names[select.selectedIndex]; // a number or a text
    if (chosen === spec.otherwise) form.remove(pointer);
    else form.set(pointer, chosen);
  });
  return field(form, pointer, spec.label, select);
}

function flag(form, spec, pointer) {
  const box = make("input", { type: "checkbox" });
  box.checked = (form.get(pointer) ?? spec.otherwise) === true;
  box.addEventListener("change", () => {
    if (box.checked === spec.otherwise) form.remove(pointer);
    else form.set(pointer, box.checked);
  });
  return field(form, pointer, spec.label, box);
}

const AXES = { vector: ["x", "y", "z"], color: ["red", "green", "blue"] };

function triple(form, spec, pointer) {
  const inputs = AXES[spec.kind].map((axis, i) => {
    const at = `${pointer}/${i}`;
    const input = make("input", { type: "text", inputmode: "decimal", autocomplete: "off", placeholder: spec.otherwise?.[i] ?? "" });
    input.value = show(form.get(at));
    const part = field(form, at, axis, input, { check: () => misfit(spec, form.get(at)) });
    form.nameOf(at, `${spec.label}, ${axis}`);
    return [input, part];
  });
  const write = () => {
    const texts = inputs.map(([input]) => input.value.trim());
    if (texts.every((text) => text === "")) form.remove(pointer);
    else form.set(pointer, texts.map((text) => text === "" ? null : parseNumber(text)));
  };
  for (const [input] of inputs) input.addEventListener("input", write);
  return group(form, pointer, spec.label, [make("div", { class: "triple" }, ...inputs.map(([, part]) => part))]);
}

function several(form, spec, pointer) {
  const value = form.get(pointer) ?? spec.otherwise;
  const boxes = spec.of.map((name) => {
    const box = make("input", { type: "checkbox", value: name, id: `${idOf(pointer)}-${name}` });
    box.checked = Array.isArray(value) && value.includes(name);
    box.addEventListener("change", () =>
      form.set(pointer, boxes.map(([one]) => one).filter((one) => one.checked).map((one) => one.value)));
    return [box, make("label", {}, box, name.replaceAll("_", " "))];
  });
  return group(form, pointer, spec.label, [make("div", { class: "several" }, ...boxes.map(([, label]) => label))]);
}

// A file of the server's by its digest, or one to be sent.
function digest(form, spec, pointer) {
  const input = make("input", { type: "text", autocomplete: "off", spellcheck: "false", maxlength: 64, class: "digest" });
  input.value = show(form.get(pointer));
  input.addEventListener("input", () => {
    if (input.value.trim() === "") form.remove(pointer);
    else form.set(pointer, input.value.trim());
    name.textContent = form.fileName(input.value.trim());
  });
  const file = make("input", { type: "file", accept: spec.accept, multiple: Boolean(spec.several), id: `${idOf(pointer)}-file`,
    "aria-describedby": `${idOf(pointer)}-state` });
  file.disabled = !form.canUpload;
  file.addEventListener("change", () => { if (file.files.length > 0) form.takeFiles([...file.files], pointer); });
  const name = make("span", { class: "hint" }, form.fileName(input.value));
  const state = make("p", { class: "hint", id: `${idOf(pointer)}-state` });
  const bar = make("progress", { max: 1, value: 0, hidden: true, "aria-label": `Upload of ${spec.label.toLowerCase()}` });
  form.uploads.set(pointer, { bar, state });
  return make("div", { class: "asset" },
    make("div", { class: "field" }, make("label", { for: file.id }, `${spec.label} file`), file, bar, state),
    field(form, pointer, `${spec.label} digest (SHA-256)`, input, { extra: [name] }));
}

export const CONTROLS = { number, integer: number, word, words, text: lines, choice, flag, vector: triple, color: triple, several, digest };

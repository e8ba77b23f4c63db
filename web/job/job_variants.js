// The controls whose shape follows their value: members that are one thing or another, the camera,
// the list of lights.
import { make } from "../elements.js";
import { field, group } from "./job_controls.js";
import { LIGHTS, LOOK_AT, LOOK_AT_FIELDS } from "./job_fields.js";

const copy = (value) => structuredClone(value);
const isObject = (value) => value !== null && typeof value === "object";
const digits = (numbers) => numbers.map((number) => Number(number.toPrecision(6)));

function variant(form, spec, pointer) {
  const now = () => Math.max(0, spec.of.findIndex(({ is }) => is(form.get(pointer))));
  const select = make("select", {}, ...spec.of.map(({ label }, i) => make("option", { value: i, selected: i === now() }, label)));
  const inside = make("div", { class: "fields" });
  const fill = () => inside.replaceChildren(...spec.of[now()].fields.map((one) => form.control(one, pointer)));
  fill();
  select.addEventListener("change", () => {
    form.forget(`${pointer}/`);
    const { value } = spec.of[Number(select.value)];
    if (isObject(value)) form.set(pointer, copy(value));
    else form.remove(pointer);
    fill();
  });
  return make("div", { class: "variant" }, field(form, pointer, spec.label, select), inside);
}

// What a camera of the form's own starts from: what the plan has seen last.
function ownCamera({ camera }) {
  if (!camera) return copy(LOOK_AT);
  const own = { eye: digits(camera.eye), target: digits(camera.eye.map((at, i) => at + 5 * camera.forward[i])), up: digits(camera.up) };
  return camera.yfov_deg ? { ...own, yfov_deg: Number(camera.yfov_deg.toPrecision(6)) } : own;
}

function camera(form, spec, pointer) {
  const select = make("select");
  const inside = make("div", { class: "fields" });
  let values = [];
  // The first of a name is meant by it; others go by their place.
  const fillChoices = () => {
    const names = form.plan?.cameras ?? [];
    const now = form.get(pointer);
    values = [["the scene's first", undefined],
      ...names.map((name, i) => name && names.indexOf(name) === i ? [name, name] : [name ? `${name} (number ${i})` : `number ${i}`, i])];
    if (!isObject(now) && now !== undefined && now !== null && !values.some(([, value]) => value === now))
      values.push([typeof now === "number" ? `number ${now}` : String(now), now]);
    values.push(["eye and target", isObject(now) ? now : {}]);
    const at = isObject(now) ? values.length - 1 : Math.max(0, values.findIndex(([, value]) => value === (now ?? undefined)));
    select.replaceChildren(...values.map(([label], i) => make("option", { value: i, selected: i === at }, label)));
  };
  const fillInside = () => inside.replaceChildren(
    ...(isObject(form.get(pointer)) ? LOOK_AT_FIELDS.map((one) => form.control(one, pointer)) : []));
  fillChoices();
  fillInside();
  select.addEventListener("change", () => {
    const [, value] = values[Number(select.value)];
    form.forget(`${pointer}/`);
    if (value === undefined) form.remove(pointer);
    else form.set(pointer, isObject(value) ? ownCamera(form.plan ?? {}) : value);
    fillInside();
  });
  form.onPlan = fillChoices;
  return make("div", { class: "variant" }, field(form, pointer, spec.label, select), inside);
}

function lights(form, spec, pointer) {
  const list = make("div", { class: "lights" });
  const now = () => { const value = form.get(pointer); return Array.isArray(value) ? value : []; };
  const fill = () => {
    form.forget(`${pointer}/`);
    list.replaceChildren(...now().map((light, i) => one(light, i)));
    for (const button of adds) button.disabled = now().length >= spec.most;
  };
  const one = (light, i) => {
    const { fields = [], hint = "" } = LIGHTS[light?.type] ?? {};
    const remove = make("button", { type: "button", "aria-label": `Remove light ${i + 1}` }, "Remove");
    remove.addEventListener("click", () => {
      const rest = now().filter((_, j) => j !== i);
      if (rest.length > 0) form.set(pointer, rest);
      else form.remove(pointer);
      fill();
      (list.children[Math.min(i, rest.length - 1)]?.querySelector("button") ?? adds[0]).focus();
    });
    return group(form, `${pointer}/${i}`, `Light ${i + 1}: ${light?.type ?? "?"}`,
      [make("div", { class: "fields" }, ...fields.map((each) => form.control(each, `${pointer}/${i}`))), remove], hint);
  };
  const adds = Object.keys(LIGHTS).map((type) => {
    const button = make("button", { type: "button" }, `Add ${type} light`);
    button.addEventListener("click", () => {
      form.set(pointer, [...now(), copy(LIGHTS[type].value)]);
      fill();
      list.lastElementChild.querySelector("input").focus();
    });
    return button;
  });
  fill();
  return group(form, pointer, spec.label, [list, make("div", { class: "bar" }, ...adds)]);
}

export const VARIANTS = { variant, camera, lights };

// The form of a job document. The document holds the state. Controls show and change it, and show()
// replaces it.
import { make } from "../elements.js";
import { CONTROLS } from "./job_controls.js";
import { GROUPS } from "./job_fields.js";
import { VARIANTS } from "./job_variants.js";
import { removeAt, setAt, valueAt } from "../picture/pointer.js";

const SCENE = { title: "Scene", fields: [{ at: "/scene/asset", label: "Scene", kind: "digest", accept: ".glb,.gltf,.obj", several: true }] };

export class JobForm {
  // onChange() after each change by a control; onFiles(files, pointer) when files were chosen.
  constructor(root, { canUpload, onChange, onFiles }) {
    Object.assign(this, { root, canUpload, onChange, takeFiles: onFiles });
    this.document = { scene: {} };
    this.fields = new Map();
    this.uploads = new Map();
    this.names = new Map(); // of files by digest
    this.opened = new Set();
    this.plan = null;
  }

  // Another document, in all controls.
  show(document) {
    const focused = this.root.contains(globalThis.document.activeElement) ? globalThis.document.activeElement.id : "";
    this.document = document;
    this.fields.clear();
    this.uploads.clear();
    this.root.replaceChildren(...[SCENE, ...GROUPS].map((group) => this.makeGroup(group)));
    if (focused) globalThis.document.getElementById(focused)?.focus();
  }

  makeGroup({ title, fields, more }) {
    // A group of one field that is a group already needs no other around it.
    if (fields.length === 1 && fields[0].kind === "several") return this.control(fields[0], "");
    const set = make("fieldset", {}, make("legend", {}, title),
      make("div", { class: "fields" }, ...fields.map((spec) => this.control(spec, ""))));
    if (!more) return set;
    const details = make("details", { open: this.opened.has(title) }, make("summary", {}, `More of ${title.toLowerCase()}`),
      make("div", { class: "fields" }, ...more.map((spec) => this.control(spec, ""))));
    details.addEventListener("toggle", () => details.open ? this.opened.add(title) : this.opened.delete(title));
    set.append(details);
    return set;
  }

  control(spec, base) {
    return (CONTROLS[spec.kind] ?? VARIANTS[spec.kind])(this, spec, base + spec.at);
  }

  get(pointer) { return valueAt(this.document, pointer); }
  set(pointer, value) { setAt(this.document, pointer, value); this.onChange(); }
  remove(pointer) { removeAt(this.document, pointer); this.onChange(); }

  register(pointer, entry) { this.fields.set(pointer, entry); }
  nameOf(pointer, label) { this.fields.get(pointer).label = label; }
  // The fields below a member that changes its shape.
  forget(prefix) {
    for (const pointer of this.fields.keys()) if (pointer.startsWith(prefix)) this.fields.delete(pointer);
  }

  fileName(digest) { return this.names.get(digest) ?? ""; }

  // What a plan tells: which cameras there are, what the one in use sees.
  takePlan(plan) {
    const known = JSON.stringify(this.plan?.cameras);
    this.plan = plan;
    if (JSON.stringify(plan.cameras) !== known) this.onPlan?.();
  }

  // What can be said of the numbers without asking: [{pointer, text}].
  misfits() {
    return [...this.fields].map(([pointer, { check }]) => ({ pointer, text: check?.() })).filter(({ text }) => text);
  }

  // Shows faults [{pointer, text}] at their fields. Returns [{text, label, control}] for a summary;
  // control is null where no field stands for the place.
  showFaults(faults) {
    for (const { control, fault } of this.fields.values()) {
      control.removeAttribute("aria-invalid");
      fault.hidden = true;
    }
    return faults.map(({ pointer, text }) => {
      const place = this.nearest(pointer);
      if (!place) return { text, label: pointer || "The document", control: null };
      const { control, fault, label } = place;
      if (control.tagName !== "FIELDSET") control.setAttribute("aria-invalid", "true");
      fault.textContent = text;
      fault.hidden = false;
      return { text, label, control };
    });
  }

  // The field of a pointer, or of what it lies in.
  nearest(pointer) {
    for (let at = pointer; at; at = at.slice(0, at.lastIndexOf("/")))
      if (this.fields.has(at)) return this.fields.get(at);
    return null;
  }
}

// Moving the objects of a live job on its picture: drags on the ground, keys, and numbers in a bar.
import { basis, dropOnLevel, nearestBox, rayThrough, shortest } from "./orbit.js";

const TURN = 5, STEP = 0.1; // of a key: degrees, and of the object's size
const A_DRAG = 360; // degrees of a drag over the picture's width

const turned = (degrees) => degrees - 360 * Math.round(degrees / 360);
const text = (v) => String(Number(v.toPrecision(4)));

export class ObjectMode {
  // `picture` is the page's PictureView, `view` its LiveView, before which this takes drags and keys.
  constructor(elements, picture, view) {
    this.at = elements;
    this.picture = picture;
    this.view = view;
    this.nodes = [];
    this.mode = false;
    const { cameraDrag, shortcuts } = picture, { before } = shortcuts;
    picture.toggleObjects = () => { if (!elements.bar.hidden) this.setMode(!this.mode); else picture.say("This job is not live."); };
    picture.cameraDrag = (...drag) => this.drag(...drag) || cameraDrag(...drag);
    shortcuts.before = (event) => (this.mode && this.key(event)) || before(event);
    elements.mode.addEventListener("click", () => this.setMode(!this.mode));
    elements.node.addEventListener("change", () => this.showState());
    elements.back.addEventListener("click", () => this.putBack());
    elements.copy.addEventListener("click", () => this.copy());
    for (const input of [...elements.place, elements.turn]) input.addEventListener("change", () => this.read());
    view.objects = this;
  }

  get live() { return this.view.live; }

  // The node that is chosen, as the plan has it.
  get node() { return this.nodes.find(({ name }) => name === this.at.node.value) ?? null; }

  // Where a node is moved to; where the file has it unless the job says else.
  moveOf(name, moves = this.live.moves) { return moves.find(({ node }) => node === name) ?? { node: name, translation: [0, 0, 0], rotation_deg: 0 }; }

  close() {
    this.setMode(false);
    this.at.bar.hidden = true;
    this.nodes = [];
  }

  // Everything that GET says of the job; null: it is not live, or not open.
  show(job) {
    const nodes = job?.plan?.nodes ?? [], movable = nodes.filter(({ role }) => role === "virtual");
    this.at.bar.hidden = movable.length === 0;
    if (this.at.bar.hidden) { this.setMode(false); return; }
    if (!this.live.settled || (job.view?.number ?? 0) < this.live.number) return; // of a view that is past
    const names = (list) => list.map(({ name }) => name).join("\n");
    if (names(movable) !== names(this.nodes)) this.at.node.replaceChildren(...movable.map(({ name }) => new Option(name, name)));
    this.nodes = movable;
    this.placed = job.document.scene.moves; // when the plan was made
    this.showState();
  }

  // The box of a node, where it is by now: turns since the plan was made are left out.
  boxOf({ name, lowest, highest }) {
    const was = this.moveOf(name, this.placed).translation, is = this.moveOf(name).translation;
    const shifted = (corner) => corner.map((v, i) => v + is[i] - was[i]);
    return { name, lowest: shifted(lowest), highest: shifted(highest) };
  }

  showState() {
    if (this.at.bar.hidden || !this.node) return;
    const { translation, rotation_deg } = this.moveOf(this.node.name);
    const show = (input, value) => { if (document.activeElement !== input) input.value = text(value); };
    this.at.place.forEach((input, i) => show(input, translation[i]));
    show(this.at.turn, rotation_deg);
  }

  setMode(on) {
    if (on === this.mode || (on && this.at.bar.hidden)) return;
    if (on) this.view.setMode(false);
    this.picture.say(on ? `moving ${this.node.name}` : "picture mode");
    this.mode = on;
    this.at.mode.setAttribute("aria-pressed", String(on));
    this.picture.at.stage.dataset.mode = on ? "objects" : "";
  }

  // Moves the chosen node to `translation`, turned by `rotation_deg`.
  put(translation, rotation_deg, at) {
    const { node, live } = this;
    if (!node) return;
    const move = { node: node.name, translation: translation.map(shortest), rotation_deg: shortest(turned(rotation_deg)) };
    const others = live.moves.filter((one) => one.node !== node.name);
    const rests = move.rotation_deg === 0 && move.translation.every((v) => v === 0);
    this.view.change({ moves: rests ? others : [...others, move] }, at);
    this.showState();
  }

  tell() {
    const { node, translation, rotation_deg } = this.moveOf(this.node.name);
    this.picture.say(`${node}: moved by ${translation.map(text).join(", ")}, turned by ${text(rotation_deg)} degrees`);
  }

  read() {
    const numbers = [...this.at.place, this.at.turn].map(({ value }) => Number(value));
    if (!this.node || numbers.some((v) => !Number.isFinite(v))) return;
    this.put(numbers.slice(0, 3), numbers[3]);
    this.tell();
  }

  putBack() {
    if (!this.node) return;
    this.put([0, 0, 0], 0);
    this.tell();
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(JSON.stringify(this.live.moves));
      this.picture.say("moves copied");
    } catch { this.picture.say("The browser does not let this page copy."); }
  }

  // The ray through a point of the canvas; null without a camera that has perspective.
  rayAt(x, y) {
    const { viewport } = this.picture, { image } = this.view.job.document;
    return this.live.camera && rayThrough(this.live.camera, viewport.toPicture(x, y), image);
  }

  drag(kind, x, y, event) {
    if (kind === "down") return this.mode && event.button === 0 && this.grab(x, y, event);
    if (!this.held) return false;
    if (kind === "up") { this.held = null; this.tell(); return true; }
    const { held } = this, { picture, zoom } = this.picture.viewport;
    if (held.turns) {
      this.put(held.from.translation, held.from.rotation_deg + (x - held.x) / (picture.width * zoom) * A_DRAG, event.timeStamp);
      return true;
    }
    const to = dropOnLevel(this.rayAt(x, y), held.level);
    if (to) this.put(held.from.translation.map((v, i) => v + to[i] - held.point[i]), held.from.rotation_deg, event.timeStamp);
    return true;
  }

  // Takes what is under the pointer, or else what is chosen. It slides on the level on which it stands.
  grab(x, y, event) {
    const ray = this.rayAt(x, y);
    if (!ray) return false;
    const found = nearestBox(ray, this.nodes.map((node) => this.boxOf(node)));
    if (found) { this.at.node.value = found.name; this.showState(); }
    const level = this.boxOf(this.node).lowest[1], point = dropOnLevel(ray, level);
    if (!point && !event.shiftKey) return false;
    event.preventDefault();
    this.held = { x, level, point, turns: event.shiftKey, from: this.moveOf(this.node.name) };
    return true;
  }

  key(event) {
    const { shiftKey: shift } = event, { translation, rotation_deg } = this.moveOf(this.node.name);
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.key === "Escape") { this.setMode(false); return true; }
    if (event.key.toLowerCase() === "n") { this.next(shift ? -1 : 1); return true; }
    if (event.key === "Backspace") { this.putBack(); return true; }
    if (!arrows[event.key]) return false;
    const [right, away] = arrows[event.key];
    if (shift && right !== 0) this.put(translation, rotation_deg + right * TURN, event.timeStamp);
    else this.put(translation.map((v, i) => v + this.stepBy(right, away, shift)[i]), rotation_deg, event.timeStamp);
    this.tell();
    return true;
  }

  // A step to the right and away from the eye along the ground, or upwards.
  stepBy(right, away, up) {
    const { lowest, highest } = this.node, step = STEP * Math.max(...highest.map((v, i) => v - lowest[i]));
    if (up) return [0, away * step, 0];
    const { right: r } = this.live.camera ? basis(this.live.camera) : { right: [1, 0, 0] }, wide = Math.hypot(r[0], r[2]) || 1;
    const [x, z] = [r[0] / wide, r[2] / wide]; // what is away is to the left of what is right
    return [(right * x + away * z) * step, 0, (right * z - away * x) * step];
  }

  next(by) {
    const { node } = this.at, { length } = node.options;
    node.selectedIndex = (node.selectedIndex + by + length) % length;
    this.showState();
    this.tell();
  }
}

// Mouse, wheel, pen and fingers on the canvas. Keys are in shortcuts.js.

export class Gestures {
  // `onDrag(kind, x, y)` may take a drag that begins ("down"), goes on ("move") and ends ("up") for
  // itself by returning true at "down", and hears of the pointer's event, too; `onWheel(event)` may take a
  // turn of the wheel the same way; `onPoint(x, y)` hears of the mouse, null when it has left;
  // `onClick(x, y)` of clicks and taps. All in pixels of the canvas.
  constructor(canvas, viewport, { onDrag, onPoint, onClick, onWheel = () => false }) {
    this.canvas = canvas;
    this.viewport = viewport;
    this.on = { drag: onDrag, point: onPoint, click: onClick, wheel: onWheel };
    this.fingers = new Map();
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.up(event));
    canvas.addEventListener("pointerleave", () => this.on.point(null));
    canvas.addEventListener("dblclick", (event) => this.twice(event));
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    const { width, height } = this.viewport.canvas; // the element's own may be smaller for a while
    return { x: (event.clientX - box.left) * width / box.width, y: (event.clientY - box.top) * height / box.height };
  }

  // Wheels zoom; touchpads' two fingers pan sideways and with shift.
  wheel(event) {
    event.preventDefault();
    if (this.on.wheel(event)) return;
    const { x, y } = this.place(event);
    const unit = event.deltaMode === 1 ? 24 : event.deltaMode === 2 ? 400 : 1;
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY))
      this.viewport.pan(-(event.deltaX || event.deltaY) * unit, event.deltaX ? -event.deltaY * unit : 0);
    else
      this.viewport.zoomBy(2 ** (-Math.max(-200, Math.min(200, event.deltaY * unit)) / 200), x, y);
  }

  down(event) {
    const at = this.place(event);
    if (event.button > 1 && this.on.drag("down", at.x, at.y, event) !== true) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, at);
    this.moved = this.fingers.size > 1;
    this.taken = this.fingers.size === 1 && (event.button > 1 || this.on.drag("down", at.x, at.y, event) === true);
  }

  move(event) {
    const at = this.place(event), before = this.fingers.get(event.pointerId);
    this.on.point(at.x, at.y);
    if (!before) return;
    if (!this.moved && Math.hypot(at.x - before.x, at.y - before.y) < 4) return;
    this.moved = true;
    if (this.taken) this.on.drag("move", at.x, at.y, event);
    else if (this.fingers.size === 1) this.viewport.pan(at.x - before.x, at.y - before.y);
    else this.pinch(event.pointerId, before, at);
    this.fingers.set(event.pointerId, at);
  }

  // Two fingers: what lies under them follows both.
  pinch(id, before, at) {
    const [, other] = [...this.fingers].find(([finger]) => finger !== id);
    const apart = (p) => Math.max(8, Math.hypot(p.x - other.x, p.y - other.y));
    this.viewport.pan((at.x - before.x) / 2, (at.y - before.y) / 2);
    this.viewport.zoomBy(apart(at) / apart(before), (at.x + other.x) / 2, (at.y + other.y) / 2);
  }

  up(event) {
    const at = this.fingers.get(event.pointerId);
    if (!this.fingers.delete(event.pointerId)) return;
    if (this.taken) this.on.drag("up", at.x, at.y, event);
    else if (!this.moved && event.type === "pointerup") this.on.click(at.x, at.y);
    this.taken = false;
  }

  // A double click goes to pixels where it was, and back to the whole.
  twice(event) {
    const { x, y } = this.place(event);
    if (this.viewport.fitted) this.viewport.zoomTo(Math.max(1, 4 * this.viewport.zoom), x, y);
    else this.viewport.fit();
  }
}

// A rectangle of the picture's pixels that is drawn with the mouse, a pen or a finger.

export class Region {
  // `onDrawn({x, y, width, height})` hears of one that is done, `onChange` of every step.
  constructor(viewport, { onDrawn, onChange }) {
    this.viewport = viewport;
    this.on = { drawn: onDrawn, change: onChange };
    this.active = false; // the next drag draws
    this.corner = this.end = null;
  }

  // As Gestures calls it, in pixels of the canvas.
  drag(kind, x, y) {
    if (!this.active) return false;
    const at = this.viewport.toPicture(x, y);
    if (kind === "down") this.corner = at;
    this.end = at;
    const drawn = kind === "up" ? this.rectangle() : null;
    if (kind === "up") this.corner = this.end = null;
    this.on.change();
    if (drawn) this.on.drawn(drawn);
    return true;
  }

  cancel() {
    this.active = false;
    this.corner = this.end = null;
    this.on.change();
  }

  // Whole pixels that it touches, inside the picture; null for none.
  rectangle() {
    if (!this.corner) return null;
    const { width, height } = this.viewport.picture, { corner, end } = this;
    const clip = (v, most) => Math.min(most, Math.max(0, v));
    const x = clip(Math.floor(Math.min(corner.x, end.x)), width), y = clip(Math.floor(Math.min(corner.y, end.y)), height);
    const right = clip(Math.ceil(Math.max(corner.x, end.x)), width), bottom = clip(Math.ceil(Math.max(corner.y, end.y)), height);
    return right > x && bottom > y ? { x, y, width: right - x, height: bottom - y } : null;
  }
}

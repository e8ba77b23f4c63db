// Which part of the picture the canvas shows. All in pixels of the canvas and of the picture.

const MOST = 128, LEAST = 1 / 64;

export class Viewport {
  constructor(onChange) {
    this.onChange = onChange;
    this.zoom = 1; // pixels of the canvas a pixel of the picture
    this.x = this.y = 0; // the picture's point in the canvas's upper left corner
    this.canvas = { width: 1, height: 1 };
    this.picture = { width: 0, height: 0 };
    this.fitted = true; // it follows the canvas's size until a zoom or pan
  }

  setCanvas(width, height) {
    const middle = this.toPicture(this.canvas.width / 2, this.canvas.height / 2);
    this.canvas = { width, height };
    if (this.fitted) this.fit();
    else this.centre(middle.x, middle.y);
  }

  setPicture(width, height) {
    if (width === this.picture.width && height === this.picture.height) return;
    this.picture = { width, height };
    this.fit();
  }

  toPicture(x, y) { return { x: this.x + x / this.zoom, y: this.y + y / this.zoom }; }

  fit() {
    this.fitted = true;
    const { canvas, picture } = this;
    if (picture.width === 0) return;
    const zoom = Math.min(canvas.width / picture.width, canvas.height / picture.height);
    this.zoom = Math.min(MOST, Math.max(LEAST, zoom));
    this.centre(picture.width / 2, picture.height / 2);
  }

  // The picture's point comes to the canvas's middle.
  centre(x, y) {
    this.x = x - this.canvas.width / 2 / this.zoom;
    this.y = y - this.canvas.height / 2 / this.zoom;
    this.changed();
  }

  pan(dx, dy) {
    this.fitted = false;
    this.x -= dx / this.zoom;
    this.y -= dy / this.zoom;
    this.changed();
  }

  // Zooms by a factor so that what lies under the canvas's point stays there; the middle by default.
  zoomBy(factor, x = this.canvas.width / 2, y = this.canvas.height / 2) { this.zoomTo(this.zoom * factor, x, y); }

  zoomTo(zoom, x = this.canvas.width / 2, y = this.canvas.height / 2) {
    const { x: px, y: py } = this.toPicture(x, y);
    this.fitted = false;
    this.zoom = Math.min(MOST, Math.max(LEAST, zoom));
    this.x = px - x / this.zoom;
    this.y = py - y / this.zoom;
    this.changed();
  }

  // At least a corner of the picture stays in sight. From 1:1 on, pixels begin at pixels.
  changed() {
    const { canvas, picture, zoom } = this;
    const keep = 32 / zoom;
    this.x = Math.min(picture.width - keep, Math.max(keep - canvas.width / zoom, this.x));
    this.y = Math.min(picture.height - keep, Math.max(keep - canvas.height / zoom, this.y));
    if (zoom === 1) { this.x = Math.round(this.x); this.y = Math.round(this.y); }
    this.onChange();
  }

  // The picture's pixels that are in sight: {x0, y0, x1, y1}.
  visible() {
    const { canvas, picture, zoom } = this;
    const clip = (v, most) => Math.min(most, Math.max(0, v));
    return {
      x0: clip(Math.floor(this.x), picture.width), y0: clip(Math.floor(this.y), picture.height),
      x1: clip(Math.ceil(this.x + canvas.width / zoom), picture.width),
      y1: clip(Math.ceil(this.y + canvas.height / zoom), picture.height),
    };
  }
}

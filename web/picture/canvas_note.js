// What is said in place of a picture, or over it: why there is none. Several things may be wrong at
// once; the heaviest is said, and the others when it is over.
const LOST = "The browser has lost the picture's graphics. The picture comes back with them; if it does not, reload the page.";

export class CanvasNote {
  constructor(element) {
    this.element = element;
    this.lost = false; // the browser's graphics
    this.fault = this.refusal = ""; // of the page; of the server, for the layer that is looked at
  }

  set(changes) {
    Object.assign(this, changes);
    const text = this.lost ? LOST : this.refusal || this.fault;
    this.element.hidden = text === "";
    if (this.element.textContent !== text) this.element.textContent = text;
  }
}

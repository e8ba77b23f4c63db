// The frames of a job in a row: small pictures with their numbers and states. Arrows, Home and End move
// among them, Enter shows one. Of long sequences a part is there, around the frame that is chosen.
import { make, setText } from "../elements.js";

const PART = 96; // frames
const TALL_PX = 54, WIDE_PX = 160;
const MOVES = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };

export class FrameStrip {
  // `onChoose(index)`: it is to be shown.
  constructor(list, onChoose) {
    Object.assign(this, { list, onChoose, frames: [], items: [], from: 0, chosen: -1, at: 0, queue: new Set(), busy: false });
    list.addEventListener("keydown", (event) => this.press(event));
    this.seen = new IntersectionObserver((entries) => entries.forEach((entry) => this.sight(entry)), { root: list, rootMargin: "0px 200px" });
  }

  clear() {
    this.frames = [];
    this.build(0);
  }

  // `frames`: [{number, words, png}], png null until it is done; `chosen`: an index, -1 for none.
  show(frames, chosen) {
    const moved = chosen !== this.chosen;
    this.frames = frames;
    this.chosen = chosen;
    if (moved && chosen >= 0) this.at = chosen;
    this.fill();
    if (moved && chosen >= 0) this.reveal(chosen);
  }

  // The part in which the frame `at` is, and what it says.
  fill() {
    const { frames } = this, from = Math.floor(Math.max(0, this.at) / PART) * PART;
    const count = Math.min(PART, frames.length - from), key = frames[from]?.number;
    if (from !== this.from || count < this.items.length || key !== this.key) this.build(from);
    this.key = key;
    while (this.items.length < count) this.items.push(this.add(this.from + this.items.length));
    this.items.forEach((item, i) => this.write(item, this.from + i));
  }

  build(from) {
    this.seen.disconnect();
    this.queue.clear();
    this.items = [];
    this.from = from;
    this.list.replaceChildren();
  }

  add(index) {
    const canvas = make("canvas", { width: TALL_PX, height: TALL_PX, "aria-hidden": "true" }), name = make("span"), words = make("span", { class: "state" });
    const button = make("button", { type: "button", tabindex: "-1" }, canvas, name, words), item = { button, canvas, name, words, png: null };
    button.addEventListener("click", () => { this.at = index; this.onChoose(index); });
    this.list.append(make("li", {}, button));
    button.item = item;
    this.seen.observe(button);
    return item;
  }

  write(item, index) {
    const { number, words, png } = this.frames[index], { button } = item;
    setText(item.name, `Frame ${number} `);
    setText(item.words, words);
    item.words.dataset.state = words;
    button.tabIndex = index === this.at ? 0 : -1;
    if (index === this.chosen) button.setAttribute("aria-current", "true");
    else button.removeAttribute("aria-current");
    if (item.png === png) return;
    item.png = png;
    item.drawn = false;
    this.ask(item);
  }

  press(event) {
    const by = MOVES[event.key];
    if (by === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.at = Math.min(this.frames.length - 1, Math.max(0, this.at + by));
    this.fill();
    this.items[this.at - this.from].button.focus();
  }

  // Scrolls the row alone, not the page.
  reveal(index) {
    const { list } = this, button = this.items[index - this.from]?.button;
    if (!button) return;
    const left = button.offsetLeft - list.offsetLeft, right = left + button.offsetWidth;
    if (left < list.scrollLeft || right > list.scrollLeft + list.clientWidth) list.scrollLeft = left - (list.clientWidth - button.offsetWidth) / 2;
  }

  sight({ target, isIntersecting }) {
    target.item.inSight = isIntersecting;
    if (isIntersecting) this.ask(target.item);
    else this.queue.delete(target.item);
  }

  ask(item) {
    if (!item.inSight || !item.png || item.drawn) return;
    this.queue.add(item);
    this.draw();
  }

  // One picture after the other: each is whole in memory until it is small.
  async draw() {
    if (this.busy) return;
    this.busy = true;
    for (const item of this.queue) {
      this.queue.delete(item);
      item.drawn = true;
      try { await paint(item); } catch { /* the number stands there */ }
    }
    this.busy = false;
  }
}

async function paint({ canvas, png }) {
  const answer = await fetch(png);
  if (!answer.ok) return;
  const bitmap = await createImageBitmap(await answer.blob(), { resizeHeight: TALL_PX, resizeQuality: "medium" });
  canvas.width = Math.min(WIDE_PX, bitmap.width);
  canvas.height = bitmap.height;
  canvas.getContext("2d").drawImage(bitmap, (canvas.width - bitmap.width) / 2, 0);
  canvas.dataset.drawn = "1";
  bitmap.close();
}

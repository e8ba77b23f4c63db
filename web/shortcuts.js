// The keys of the picture, and the sheet that lists them. Keys with letters act while the picture
// has the focus only, so that they do not get in the way (WCAG 2.1.4).

export class Shortcuts {
  // `actions`: [{keys: ["ArrowLeft", ...], name, run}], keys as KeyboardEvent.key, "Shift+" before
  // those that need it. `dialog` with a `list` (a dl) is the sheet.
  constructor(target, actions, { dialog, list, open, close }) {
    this.dialog = dialog;
    this.list = list;
    this.runs = new Map();
    this.add(actions);
    target.addEventListener("keydown", (event) => this.press(event));
    open.addEventListener("click", () => this.toggle());
    close.addEventListener("click", () => dialog.close());
  }

  // More keys, and their lines of the sheet.
  add(actions) {
    for (const { keys, run } of actions)
      for (const key of keys) {
        if (this.runs.has(key)) throw new Error(`the key ${key} has two meanings`);
        this.runs.set(key, run);
      }
    for (const { keys, name, shown } of actions) {
      if (!name) continue;
      const term = document.createElement("dt"), text = document.createElement("dd");
      for (const key of shown ?? keys) {
        const cap = document.createElement("kbd");
        cap.textContent = key;
        term.append(cap, " ");
      }
      text.textContent = name;
      this.list.append(term, text);
    }
  }

  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.before?.(event)) { event.preventDefault(); return; } // a mode of the picture has taken it
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const run = (event.shiftKey ? this.runs.get(`Shift+${key}`) : null) ?? this.runs.get(event.key) ?? this.runs.get(key);
    if (!run) return;
    event.preventDefault();
    run(event);
  }

  toggle() {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}

// A job's name, labels and comment, changed in a dialog: also when the job has ended.
import { steerJob } from "../api.js";
import { make } from "../elements.js";

export class Marks {
  // `button` opens the dialog; `onJob` gets the job as it is then.
  constructor(button, onJob) {
    this.onJob = onJob;
    this.name = make("input", { id: "mark-name", maxlength: 200, autocomplete: "off" });
    this.labels = make("input", { id: "mark-labels", autocomplete: "off", "aria-describedby": "mark-hint" });
    this.comment = make("textarea", { id: "mark-comment", rows: 4, maxlength: 4000 });
    this.problem = make("p", { id: "mark-problem", role: "alert", hidden: true });
    const cancel = make("button", { type: "button" }, "Leave it as it was");
    const form = make("form", { method: "dialog" },
      make("h2", { id: "mark-title" }, "Name and labels"),
      make("p", {}, make("label", { for: "mark-name" }, "Name "), this.name),
      make("p", {}, make("label", { for: "mark-labels" }, "Labels "), this.labels, make("span", { id: "mark-hint", class: "hint" }, " parted by commas")),
      make("p", {}, make("label", { for: "mark-comment" }, "Comment "), this.comment),
      this.problem, make("div", { class: "bar" }, make("button", { type: "submit" }, "Save"), cancel));
    this.dialog = make("dialog", { id: "mark", "aria-labelledby": "mark-title" }, form);
    document.body.append(this.dialog);
    button.addEventListener("click", () => this.open());
    cancel.addEventListener("click", () => this.dialog.close());
    form.addEventListener("submit", (event) => { event.preventDefault(); this.save(); });
  }

  // The job that the dialog is to open with.
  show(job) { this.job = job; }

  open() {
    const { document: { name, labels, comment }, id } = this.job;
    this.id = id;
    this.name.value = name ?? "";
    this.labels.value = (labels ?? []).join(", ");
    this.comment.value = comment ?? "";
    this.problem.hidden = true;
    this.dialog.showModal();
  }

  async save() {
    const labels = this.labels.value.split(",").map((label) => label.trim()).filter(Boolean);
    try {
      const job = await steerJob(this.id, { name: this.name.value.trim() || null, labels, comment: this.comment.value.trim() || null });
      this.dialog.close();
      this.onJob(job);
    } catch (error) {
      this.problem.textContent = error.message;
      this.problem.hidden = false;
    }
  }
}

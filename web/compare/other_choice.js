// What a layer is compared with, where it is not of the job itself: another job, a file of the person's, the job
// without filters. `view`: the PictureView.
import { getJob } from "../api.js";
import { readPictureFile } from "../picture/picture_file.js";
import { unfilteredTwin } from "../picture/unfiltered.js";

const ID = /^[0-9a-z]{26}$/;

// A job to compare with, by its id or its page's address; nothing: the job itself.
export async function chooseOtherJob(view) {
  const text = view.at.otherJob.value.trim(), id = text.split("/").pop();
  let layers = view.layers, problem = "";
  view.stopOther();
  view.otherJob = view.otherFile = null;
  view.at.otherFile.value = "";
  if (text) {
    try {
      if (!ID.test(id)) throw new Error("This is not a job's id.");
      layers = (await getJob(id)).document?.layers ?? ["beauty"];
      view.otherJob = id;
    } catch (error) { problem = error.status === 404 ? "There is no such job." : error.message; }
  }
  view.at.otherJob.setAttribute("aria-invalid", String(problem !== ""));
  chosenOther(view, layers, problem);
}

// A file of the person's own to compare with.
export async function chooseOtherFile(view, file) {
  if (!file) return;
  let problem = "", chosen = null;
  try { chosen = await readPictureFile(file); } catch (error) { problem = error.message; }
  view.stopOther();
  view.otherFile = chosen;
  view.otherJob = null;
  view.at.otherJob.value = "";
  chosenOther(view, chosen?.names() ?? view.layers, problem);
}

function chosenOther(view, layers, problem) {
  view.at.otherProblem.textContent = problem;
  view.at.otherBefore.checked = false;
  view.fill(view.at.otherLayer, layers, layers.includes(view.source?.layer) ? view.source.layer : layers[0]);
  if (view.compare.mode === "off") view.setCompare("wipe");
  else view.followOther();
}

// Filtered and unfiltered in turn. The first time the twin is submitted.
export async function showUnfiltered(view) {
  const { job } = view, of = `${job} ${view.source?.image.view ?? ""}`; // a live job is another with each move
  if (view.twin?.of !== of) {
    view.at.otherProblem.textContent = "";
    try {
      view.twin = { of, ...await unfilteredTwin(job) };
      if (view.job !== job) return;
    } catch (error) {
      view.at.otherProblem.textContent = error.message;
      return;
    }
  }
  if (view.otherJob === view.twin.id && view.compare.mode !== "off") { view.flip(); return; }
  view.stopOther();
  view.otherFile = null;
  view.at.otherBefore.checked = false;
  view.otherJob = view.at.otherJob.value = view.twin.id;
  view.fill(view.at.otherLayer, view.twin.layers, view.source.layer);
  view.setCompare("toggle");
  view.flip();
}

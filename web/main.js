// Puts the page together: the list, one job, the state of the connection. Jobs are bookmarkable:
// #/jobs/ID.
import { listWorkers } from "./api.js";
import { JobList } from "./job/job_list.js";
import { showConnection } from "./connection.js";
import { JobPanel } from "./job/job_panel.js";
import { JobView } from "./job/job_view.js";
import { LiveView } from "./camera/live_view.js";
import { ObjectMode } from "./camera/object_mode.js";
import { PictureView } from "./picture/picture_view.js";

const $ = (id) => document.getElementById(id);

const picture = new PictureView({
  stage: $("stage"), canvas: $("canvas"), overlay: $("overlay"), note: $("canvas-note"), layer: $("layer"),
  zoomText: $("zoom-text"), zoomIn: $("zoom-in"), zoomOut: $("zoom-out"), fit: $("fit"), actual: $("actual"),
  shownAs: $("shown-as"), tone: $("tone"), exposure: $("exposure"), exposureText: $("exposure-text"),
  gamma: $("gamma"), gammaText: $("gamma-text"), curve: $("curve"), dither: $("dither"), clipMarks: $("clip-marks"),
  reset: $("exposure-reset"), range: $("range"), low: $("low"), high: $("high"), auto: $("auto"), logarithmic: $("logarithmic"),
  compare: $("compare"), others: $("others"), otherLayer: $("other-layer"), otherJob: $("other-job"), otherFile: $("other-file"),
  flicker: $("flicker"), flickerText: $("flicker-text"), otherBefore: $("other-before"), otherBeforeLabel: $("other-before-label"),
  otherProblem: $("other-problem"), wipe: $("wipe"), position: $("wipe-position"), angle: $("wipe-angle"),
  flip: $("flip"), unfiltered: $("unfiltered"), figures: $("figures"), alike: $("alike"), legend: $("legend"), legendEnds: [$("legend-low"), $("legend-high")],
  behind: $("behind"), behindLabel: $("behind-label"), histogram: $("histogram"), histogramText: $("histogram-text"),
  readout: $("readout"), underText: $("under-text"), pins: $("pins"), said: $("said"),
  sheet: { dialog: $("keys"), list: $("keys-list"), open: $("keys-open"), close: $("keys-close") },
}, (state, error) => { if (state === "lost" && error) showConnection("connecting", error); });
const live = new LiveView({
  bar: $("live"), mode: $("camera-mode"), focus: $("camera-focus"), copy: $("camera-copy"), make: $("make-live"),
  aperture: $("camera-aperture"), distance: $("camera-distance"), state: $("live-state"), problem: $("live-problem"),
  makeProblem: (text) => view.showProblem(text),
}, picture);
new ObjectMode({
  bar: $("objects"), mode: $("object-mode"), node: $("object"), place: [$("object-x"), $("object-y"), $("object-z")], turn: $("object-turn"),
  back: $("object-back"), copy: $("object-copy"),
}, picture, live);
const view = new JobView(picture, {
  section: $("job"), title: $("job-title"), announce: $("announce"),
  progress: $("progress"), progressText: $("progress-text"), problem: $("problem"),
  download_exr: $("download-exr"), download_png: $("download-png"),
  warnings: $("warnings"),
  steering: {
    cancel: $("cancel"), cancelDialog: $("cancel-dialog"), cancelYes: $("cancel-yes"), cancelNo: $("cancel-no"),
    pause: $("pause"), priority: $("priority"), lower: $("priority-lower"), raise: $("priority-raise"),
    seen: $("first-seen"), draw: $("first-draw"), clear: $("first-clear"), region: $("first-text"),
    follow: $("follow"), more: $("more"), problem: $("steer-problem"),
  },
  player: {
    bar: $("player"), strip: $("strip"), play: $("play"), previous: $("frame-previous"), next: $("frame-next"),
    slider: $("frame"), flicker: $("flicker"), forming: $("frame-forming"), text: $("frame-text"),
  },
  live,
}, showConnection);
const panel = new JobPanel({
  section: $("panel"), again: $("again"), standing: $("standing"), plan: $("plan"), skippedPart: $("skipped-part"),
  skippedTitle: $("skipped-title"), skipped: $("skipped"), times: $("times"), rays: $("rays"), statistics: $("statistics"),
  log: $("log"), mark: $("mark-open"),
}, () => {}, (job) => view.show(job));
const list = new JobList({ list: $("jobs"), empty: $("jobs-empty"), more: $("jobs-more") }, showConnection);

function route() {
  const id = /^#\/jobs\/([0-9a-z]{26})$/.exec(location.hash)?.[1];
  $("nothing").hidden = Boolean(id);
  list.select(id);
  if (id) view.open(id);
  else view.close();
  panel.open(id ?? null);
  document.title = id ? `Job ${id.slice(-6)} · Shearwater` : "Shearwater";
}
addEventListener("hashchange", route);
route();

async function countWorkers() {
  try {
    const { length } = (await listWorkers()).workers ?? [];
    $("workers").textContent = length === 1 ? "1 worker" : `${length} workers`;
  } catch { /* the connection says so */ }
  setTimeout(countWorkers, 5000);
}
countWorkers();

// The page that makes a job: a form and its document as JSON, kept in step; every change is checked by
// the server, which tells the plan before anything is submitted.
import { getJob, submitJob } from "./api.js";
import { showConnection } from "./connection.js";
import { DryRun } from "./job/dry_run.js";
import { definitions, make } from "./elements.js";
import { planRows, skippedRows } from "./job/facts.js";
import { JobForm } from "./job/job_form.js";
import { markPage } from "./navigation.js";
import { canHash, upload, WHY_NOT } from "./job/upload.js";

const $ = (id) => document.getElementById(id);
const form = new JobForm($("fields"), { canUpload: canHash(), onChange: () => changed("form"), onFiles: takeFiles });
const dryRun = new DryRun(judge);
let serverFault = null, jsonFault = null, sending = 0, key = null;

// ---- the document, as fields and as text

function changed(by) {
  key = null;
  if (by !== "text") {
    $("json").value = JSON.stringify(form.document, null, 2);
    jsonFault = null;
  }
  serverFault = null;
  $("checking").hidden = true;
  showFaults();
  if (jsonFault) { dryRun.stop(); say(""); return; }
  if (sending > 0 || !form.get("/scene/asset")) { dryRun.stop(); say(sending ? "" : "Choose a scene first."); return; }
  $("checking").hidden = false;
  dryRun.check(form.document);
}

$("json").addEventListener("input", () => {
  try {
    const value = JSON.parse($("json").value);
    if (value === null || typeof value !== "object" || Array.isArray(value)) throw new Error("a job document is an object");
    jsonFault = null;
    form.show(value);
  } catch (error) {
    jsonFault = error.message;
  }
  changed("text");
});

// ---- what is wrong with it

function showFaults() {
  const local = form.misfits();
  const all = serverFault && !local.some(({ pointer }) => pointer === serverFault.pointer) ? [serverFault, ...local] : local;
  const lines = form.showFaults(all);
  $("json-fault").hidden = !jsonFault;
  $("json-fault").textContent = jsonFault ?? "";
  if (jsonFault) $("json").setAttribute("aria-invalid", "true");
  else $("json").removeAttribute("aria-invalid");
  if (jsonFault) lines.push({ label: "The document as JSON", text: jsonFault, control: $("json") });
  $("faults").replaceChildren(...lines.map(faultLine));
  $("summary").hidden = lines.length === 0;
  return lines.length;
}

function faultLine({ label, text, control }) {
  const target = control ?? $("json");
  const link = make("a", { href: `#${target.id}` }, `${label}: ${text}`);
  link.addEventListener("click", (event) => {
    event.preventDefault();
    for (let at = target; (at = at.parentElement?.closest("details")); at = at.parentElement) at.open = true;
    target.focus();
    target.scrollIntoView({ block: "center" });
  });
  return make("li", {}, link);
}

const say = (text) => { if ($("said").textContent !== text) $("said").textContent = text; };

// ---- what the server thinks of it

function judge({ plan, fault, trouble }) {
  showConnection(trouble ? "lost" : "live");
  $("checking").hidden = true;
  if (trouble) { say(`Not checked: ${trouble}. Trying again.`); return; }
  serverFault = fault ?? null;
  const count = showFaults();
  say(fault ? `${count === 1 ? "1 problem" : `${count} problems`} to fix.` : "The job is valid. Its plan:");
  $("submit").toggleAttribute("data-ready", !fault);
  showPlan(fault ? null : plan);
  if (plan) form.takePlan(plan);
}

function showPlan(plan) {
  const skipped = skippedRows(plan);
  $("plan").replaceChildren(...definitions(planRows(plan)));
  $("skipped").replaceChildren(...definitions(skipped));
  $("skipped-title").textContent = `Skipped: ${skipped.length}, and why`;
  $("skipped-part").hidden = skipped.length === 0;
  $("warnings").replaceChildren(...(plan?.warnings ?? []).map((text) => make("li", {}, text)));
}

// ---- files

// What "shearwater render scene.glb" asks for beside the scene (server/cli/job_file.c).
const BARE_JOB = { scene: { default_camera: "three_quarter" }, effects: { indirect_bounces: 12 } };
const addBareJob = (document) => {
  for (const [member, defaults] of Object.entries(BARE_JOB)) document[member] = { ...defaults, ...document[member] };
};
const isUntouched = ({ scene, ...others }) => Object.keys(others).length === 0 && Object.keys(scene ?? {}).length === 0;

const kindOf = (name) => /\.(glb|gltf|obj)$/i.test(name) ? "scene" : /\.(hdr|exr)$/i.test(name) ? "environment" : "beside";
const CHOSEN = { "/environment/asset": "environment", "/backplate/asset": "backplate" };

// Files that are chosen for a place go there. Others are told apart by their names; those beside a scene are named as it names them.
async function takeFiles(files, pointer = null) {
  const scene = files.filter(({ name }) => kindOf(name) === "scene"), map = files.filter(({ name }) => kindOf(name) === "environment");
  if (scene.length > 1 || map.length > 1) { say("Choose one scene and one environment at a time."); return; }
  const bare = isUntouched(form.document);
  for (const file of files) {
    const kind = CHOSEN[pointer] ?? kindOf(file.name);
    const place = { scene: "/scene/asset", environment: "/environment/asset", backplate: "/backplate/asset", beside: "/scene/asset" }[kind];
    const digest = await send(file, place);
    if (!digest) continue;
    form.names.set(digest, file.name);
    if (kind === "scene" && bare) addBareJob(form.document);
    if (kind === "environment") form.document.environment = { ...form.document.environment, asset: digest };
    else if (kind === "backplate") form.document.backplate = { ...form.document.backplate, asset: digest };
    else if (kind === "scene") form.document.scene = { ...form.document.scene, asset: digest };
    else form.document.scene = { ...form.document.scene, files: { ...form.document.scene?.files, [file.name]: digest } };
    if (kind === "environment") delete form.document.environment.radiance;
    form.show(form.document);
    tell(place, `${file.name} is uploaded.`);
  }
  changed("form");
}

function tell(place, text, share = null) {
  const { bar, state } = form.uploads.get(place) ?? form.uploads.get("/scene/asset");
  state.textContent = text;
  bar.hidden = share === null;
  if (share !== null) bar.value = share;
}

async function send(file, place) {
  let told = -1;
  sending++;
  changed("form");
  try {
    return await upload(file, (doing, share) => {
      const tens = Math.floor(share * 10) * 10;
      tell(place, doing === "hashing" ? `Hashing ${file.name}…` : `Sending ${file.name}: ${Math.floor(share * 100)} %`, doing === "hashing" ? null : share);
      if (tens > told) { told = tens; $("upload-said").textContent = doing === "hashing" ? `Hashing ${file.name}` : `${tens} percent sent`; }
    });
  } catch (error) {
    tell(place, `${file.name}: ${error.message}`);
    $("upload-said").textContent = `${file.name} could not be uploaded: ${error.message}`;
    return null;
  } finally {
    sending--;
  }
}

addEventListener("dragover", (event) => { if (form.canUpload) { event.preventDefault(); $("drop").dataset.over = ""; } });
addEventListener("dragleave", () => { delete $("drop").dataset.over; });
addEventListener("drop", (event) => {
  event.preventDefault();
  delete $("drop").dataset.over;
  if (form.canUpload && event.dataTransfer?.files.length) takeFiles([...event.dataTransfer.files]);
});

// ---- submitting

const newKey = () => `page-${[...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;

$("form").addEventListener("submit", async (event) => {
  event.preventDefault();
  if (sending > 0) { say("A file is still being uploaded."); return; }
  if (jsonFault) { showFaults(); $("summary").focus(); return; }
  $("submit").disabled = true;
  key ??= newKey(); // the same as long as the document is: pressed twice, it is one job
  try {
    const { id } = await submitJob(form.document, key);
    location.assign(`./#/jobs/${id}`);
  } catch (error) {
    $("submit").disabled = false;
    if (error.status >= 400 && error.status < 500) {
      serverFault = { pointer: error.pointer ?? "", text: error.message };
      showFaults();
      $("summary").focus();
    } else say(`Not submitted: ${error.message}.`);
  }
});
addEventListener("pageshow", () => { $("submit").disabled = false; });

// ---- what it begins with

async function begin() {
  const id = new URLSearchParams(location.search).get("job");
  if (id && /^[0-9a-z]{26}$/.test(id)) {
    document.title = "Edit job · Shearwater";
    $("title").textContent = `Copy of job ${id.slice(-8)}`;
    try {
      form.show((await getJob(id)).document);
      changed("form");
      return;
    } catch (error) {
      $("title").textContent = "New job";
      form.show({ scene: {} });
      changed("form");
      say(error.status === 404 ? `There is no job ${id}.` : error.message);
      return;
    }
  }
  form.show({ scene: {} });
  changed("form");
}

$("insecure").hidden = canHash();
$("insecure").textContent = canHash() ? "" : WHY_NOT();
$("drop").hidden = !canHash();
markPage("submit.html");
showConnection("live");
begin();

// The form that makes jobs, in a real Chromium against a real coordinator with real workers. TAP.
//   node tests/browser/submit.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { parse } from "yaml";
import { glbOf } from "../bench/scenes/glb.mjs";
import { sphere } from "../bench/scenes/mesh.mjs";
import { encodePicture } from "../bench/scenes/png.mjs";
import { GROUPS, LAYERS, LIGHTS, LOOK_AT_FIELDS } from "../../web/job/job_fields.js";
import { clean, narrow } from "./axe.mjs";
import { build, expect, look, openPage, runAll, shots, startServer, test, text, tmp, until } from "./house.mjs";

const scene = resolve("tests/scenes/cornell-box/cornell-box.glb");
const digest = createHash("sha256").update(readFileSync(scene)).digest("hex");

// The contract's schemas: a member by its pointer, whichever of its shapes has it.
const contract = parse(readFileSync("proto/openapi.yaml", "utf8"));
const follow = (node) => node?.$ref
  ? { ...follow(node.$ref.slice(2).split("/").reduce((at, part) => at[part], contract)), ...node, $ref: undefined } : node;
const shapes = (node) => [node, ...(node?.oneOf ?? [])].map(follow);
function schemaAt(root, pointer) {
  let at = follow(root);
  for (const part of pointer.split("/").slice(1)) {
    const found = shapes(at).map((shape) => follow(shape?.properties?.[part])).find(Boolean);
    if (!found) return null;
    at = found;
  }
  return at;
}

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { reducedMotion: "reduce" });
  const shot = (name) => join(shots, `submit-${name}.png`);
  const get = async (path) => (await page.request.get(url + path)).json();
  const id = (pointer) => `#f${pointer.replaceAll("/", "-")}`;
  const planned = () => until("the plan", async () => await page.locator("#checking").isHidden() && /The job is valid/.test(await text(page, "said")));
  const documentNow = async () => JSON.parse(await page.inputValue("#json"));
  const faultAt = (pointer) => page.textContent(`${id(pointer)}-fault`);

  const drop = async (path) => {
    const dataTransfer = await page.evaluateHandle(([base64, name]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
      return transfer;
    }, [readFileSync(path).toString("base64"), basename(path)]);
    await page.dispatchEvent("#drop", "dragover", { dataTransfer });
    await page.dispatchEvent("#drop", "drop", { dataTransfer });
  };

  await test("the form's limits, choices and defaults are the contract's", async () => {
    const wrong = [], job = contract.components.schemas.Job;
    const judge = (spec, root, pointer) => {
      const all = shapes(schemaAt(root, pointer)).filter(Boolean);
      if (all.length === 0) { wrong.push(`${pointer} is not in the contract`); return; }
      const own = spec.kind === "vector" || spec.kind === "color" ? [follow(all[0].items)] : spec.kind === "several" ? shapes(all[0].items) : all;
      const has = (name) => own.map((shape) => shape?.[name]).find((value) => value !== undefined);
      for (const [mine, its] of [["min", "minimum"], ["max", "maximum"], ["above", "exclusiveMinimum"]])
        if (["number", "integer", "vector", "color"].includes(spec.kind) && spec[mine] !== has(its)) wrong.push(`${pointer}: ${mine} ${spec[mine]}, not ${has(its)}`);
      if (["choice", "several"].includes(spec.kind) && spec.of.join() !== (has("enum") ?? []).join()) wrong.push(`${pointer}: ${spec.of}, not ${has("enum")}`);
      if (spec.kind === "lights" && spec.most !== all[0].maxItems) wrong.push(`${pointer}: ${spec.most}, not ${all[0].maxItems}`);
      const otherwise = all.map((shape) => shape.default).find((value) => value !== undefined);
      if ("otherwise" in spec && JSON.stringify(spec.otherwise) !== JSON.stringify(otherwise)) wrong.push(`${pointer}: default ${spec.otherwise}, not ${otherwise}`);
      for (const variant of spec.kind === "variant" ? spec.of : [])
        for (const one of variant.fields) judge(one, root, pointer + one.at);
    };
    for (const { fields, more = [] } of GROUPS) for (const spec of [...fields, ...more]) judge(spec, job, spec.at);
    for (const spec of LOOK_AT_FIELDS) judge(spec, contract.components.schemas.LookAt, spec.at);
    for (const [type, { fields, value }] of Object.entries(LIGHTS)) {
      const schema = contract.components.schemas[`${type[0].toUpperCase()}${type.slice(1)}Light`];
      for (const spec of fields) judge(spec, schema, spec.at);
      for (const name of schema.required) if (!(name in value)) wrong.push(`a new ${type} light has no ${name}`);
    }
    // Of frames the form asks for the first and the last; a list is a document's alone, and so are moves, which are made in the viewer.
    const asked = new Set(GROUPS.flatMap(({ fields, more = [] }) => [...fields, ...more]).map(({ at }) => at));
    for (const [name, member] of Object.entries(job.properties)) {
      const inner = Object.keys(follow(member).properties ?? {});
      for (const pointer of inner.length > 0 ? inner.map((one) => `/${name}/${one}`) : [`/${name}`])
        if (!asked.has(pointer) && !["/scene/asset", "/scene/files", "/scene/moves", "/frames"].includes(pointer)) wrong.push(`${pointer} is not asked for`);
    }
    expect(LAYERS.length > 10 && wrong.length === 0, wrong.join("; "));
  });

  await test("an empty form asks for a scene and submits nothing", async () => {
    await page.goto(`${url}/submit.html`);
    await until("the sentence", async () => (await text(page, "said")) === "Choose a scene first.");
    await page.click("#submit");
    await until("the fault", async () => (await faultAt("/scene/asset")).length > 0);
    expect((await get("/v1/jobs")).jobs.length === 0, "a job was made");
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/422|400/.test(line)));
    await clean(page, "the empty form");
  });

  await test("a scene that is dropped is hashed, sent and planned", async () => {
    await page.goto(`${url}/submit.html`);
    await until("the form", () => page.locator("#drop").isVisible());
    await drop(scene);
    await planned();
    expect(await page.inputValue(id("/scene/asset")) === digest, "another digest");
    expect((await page.request.head(`${url}/v1/assets/${digest}`)).status() === 200, "the server does not have it");
    expect((await page.textContent(".asset .hint")).length > 0 && (await page.textContent("#fields")).includes("cornell-box.glb"), "its name is not shown");
    const { plan } = await (await page.request.post(`${url}/v1/jobs?dry_run=1`, { data: await documentNow() })).json();
    expect((await text(page, "plan")).includes(plan.filter_why), await text(page, "plan"));
    expect((await page.locator("#skipped dt").count()) === plan.skipped.length, "other skips");
    await page.screenshot({ path: shot("planned"), fullPage: true });
    await clean(page, "the planned form");
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/404/.test(line))); // HEAD of what was not there
  });

  await test("the cameras of the file are there to be chosen, and one of the form's own begins there", async () => {
    const options = await page.locator(`${id("/scene/camera")} option`).allTextContents();
    const { plan } = await (await page.request.post(`${url}/v1/jobs?dry_run=1`, { data: { scene: { asset: digest } } })).json();
    expect(plan.cameras.length > 0 && plan.cameras.every((name, i) => options.some((option) => name ? option.startsWith(name) : option === `number ${i}`)), options.join());
    await page.selectOption(id("/scene/camera"), { label: "eye and target" });
    const { scene: { camera } } = await documentNow();
    expect(camera.eye.every((value, i) => Math.abs(value - plan.camera.eye[i]) < 1e-4), JSON.stringify(camera));
    await planned();
    const { plan: own } = await (await page.request.post(`${url}/v1/jobs?dry_run=1`, { data: await documentNow() })).json();
    expect(own.camera.forward.every((value, i) => Math.abs(value - plan.camera.forward[i]) < 1e-3), "it looks elsewhere");
    await page.selectOption(id("/scene/camera"), { label: "the scene's first" });
    expect(!("camera" in (await documentNow()).scene), "the camera stays in the document");
  });

  await test("what the server refuses is said at its field and in the summary, whose link goes there", async () => {
    await page.selectOption(id("/lens"), { label: "thin lens" });
    await page.fill(id("/lens/focus_distance"), "");
    await until("the fault", async () => (await faultAt("/lens/focus_distance")).length > 0);
    expect(await page.getAttribute(id("/lens/focus_distance"), "aria-invalid") === "true", "not marked");
    const described = await page.getAttribute(id("/lens/focus_distance"), "aria-describedby");
    expect(described.includes(`${id("/lens/focus_distance").slice(1)}-fault`), described);
    const link = page.locator("#faults a");
    expect(/^Focus distance: /.test(await link.textContent()), await link.textContent());
    await page.screenshot({ path: shot("fault") });
    await clean(page, "a fault");
    await link.focus();
    await page.keyboard.press("Enter");
    expect(await page.evaluate((wanted) => `#${document.activeElement.id}` === wanted, id("/lens/focus_distance")), "the focus is elsewhere");
    await page.keyboard.type("3.5");
    await planned();
    expect(await page.locator("#summary").isHidden() && (await page.getAttribute(id("/lens/focus_distance"), "aria-invalid")) === null, "the fault stays");
  });

  await test("several faults are all in the summary; submitting leads to them", async () => {
    await page.fill(id("/image/width"), "0");
    await page.fill(id("/sampling/spp"), "many");
    await until("two lines", async () => (await page.locator("#faults li").count()) === 2);
    const lines = (await page.locator("#faults a").allTextContents()).sort();
    expect(/Samples per pixel: /.test(lines[0]) && /Width.*: 0 is below 1/.test(lines[1]), lines.join("; "));
    await page.click("#submit");
    await until("the focus on the summary", () => page.evaluate(() => document.activeElement.id === "summary"));
    await page.fill(id("/image/width"), "96");
    await page.fill(id("/image/height"), "96");
    await page.fill(id("/sampling/spp"), "4");
    await planned();
  });

  await test("lights are added, filled in and removed by keys", async () => {
    await page.locator("button", { hasText: "Add spot light" }).focus();
    await page.keyboard.press("Enter");
    expect(await page.evaluate((wanted) => `#${document.activeElement.id}` === wanted, id("/lights/0/position/0")), "the focus is not on the new light");
    await page.fill(id("/lights/0/inner_deg"), "50");
    await until("the server's fault", async () => (await faultAt("/lights/0/inner_deg")).length > 0);
    await page.fill(id("/lights/0/inner_deg"), "10");
    await page.locator("button", { hasText: "Add rectangle light" }).click();
    await page.fill(id("/lights/1/radiance/2"), "2.5");
    await planned();
    const { lights } = await documentNow();
    expect(lights.length === 2 && lights[0].inner_deg === 10 && lights[1].radiance.join() === "10,10,2.5", JSON.stringify(lights));
    await page.screenshot({ path: shot("lights"), fullPage: true });
    await page.locator('button[aria-label="Remove light 1"]').focus();
    await page.keyboard.press("Enter");
    expect((await documentNow()).lights.map(({ type }) => type).join() === "rectangle", "the wrong light went");
  });

  await test("fields and JSON are kept in step, both ways", async () => {
    await page.locator("#json-part summary").click();
    const document = await documentNow();
    document.image.width = 120;
    document.environment = { radiance: [0.5, 0.5, 1] };
    document.layers = ["beauty", "depth"];
    await page.fill("#json", JSON.stringify(document));
    expect(await page.inputValue(id("/image/width")) === "120", "the width's field is not changed");
    expect(await page.inputValue(id("/environment/radiance/2")) === "1", "the environment's field is not there");
    expect(await page.isChecked('input[value="depth"]') && !await page.isChecked('input[value="albedo"]'), "other layers");
    await planned();
    await page.fill("#json", '{"scene": ');
    await until("its fault", async () => (await text(page, "json-fault")).length > 0);
    expect(/The document as JSON: /.test(await page.textContent("#faults a")), "not in the summary");
    await page.fill("#json", JSON.stringify({ ...document, lamps: [] }));
    await until("the unknown member", async () => /lamps/.test(await text(page, "faults")));
    await page.fill("#json", JSON.stringify(document));
    await planned();
    await page.check('input[value="normal"]');
    expect((await documentNow()).layers.join() === "beauty,normal,depth" || (await documentNow()).layers.includes("normal"), "the JSON does not follow");
    await page.selectOption(id("/environment"), { label: "none" });
    expect(!("environment" in await documentNow()), "the environment stays");
    await page.fill(id("/image/height"), "");
    expect(!("height" in (await documentNow()).image), "an empty field stays in the document");
    await page.fill(id("/image/height"), "96");
  });

  await test("an environment map is chosen like a scene", async () => {
    const map = join(tmp, "sky.hdr");
    writeFileSync(map, Buffer.concat([Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"), Buffer.from(Array(8).fill([0x80, 0x80, 0x80, 0x81]).flat())]));
    await page.selectOption(id("/environment"), { label: "a map" });
    await page.setInputFiles(`${id("/environment/asset")}-file`, map);
    await planned();
    expect((await documentNow()).environment.asset === createHash("sha256").update(readFileSync(map)).digest("hex"), "another digest");
    expect(/a map/.test(await text(page, "plan")), await text(page, "plan"));
    await page.selectOption(id("/environment"), { label: "none" });
    await page.selectOption(id("/lens"), { label: "pinhole" });
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/404|422/.test(line)));
  });

  await test("a photograph goes behind the objects, whatever its name says", async () => {
    const { scene } = await documentNow();
    await page.selectOption(id("/backplate"), { label: "a photograph" });
    await page.selectOption(id("/backplate/fit"), "stretch");
    for (const [name, grey] of [["table.png", 128], ["table.exr", 64]]) { // the file's bytes tell what it is
      const photograph = encodePicture(Buffer.alloc(4 * 4 * 3, grey), 4, 4), digest = createHash("sha256").update(photograph).digest("hex");
      writeFileSync(join(tmp, name), photograph);
      await page.setInputFiles(`${id("/backplate/asset")}-file`, join(tmp, name));
      await until(name, async () => (await documentNow()).backplate?.asset === digest);
    }
    await planned();
    const now = await documentNow();
    expect(JSON.stringify(now.scene) === JSON.stringify(scene) && !now.environment, JSON.stringify(now));
    await page.selectOption(id("/backplate"), { label: "none" });
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/404|422/.test(line)));
  });

  let made = null;
  await test("the job is submitted once, and its page shows it to the end: 100 % only then", async () => {
    await planned();
    const wanted = await documentNow();
    const keys = [];
    page.on("request", (request) => { if (request.method() === "POST" && /\/v1\/jobs$/.test(request.url())) keys.push(request.headers()["idempotency-key"]); });
    await page.click("#submit");
    await page.waitForURL(/#\/jobs\/[0-9a-z]{26}$/, { timeout: 15000 });
    made = page.url().slice(-26);
    await until("finished", async () => {
      const value = await page.locator("#progress").evaluate((bar) => bar.value);
      const words = await text(page, "progress-text");
      expect(value < 100 || /finished/.test(words), `100 % with "${words}"`);
      return /^100 % · finished/.test(words);
    }, 60);
    expect(keys.length === 1 && /^page-[0-9a-f]{32}$/.test(keys[0]), keys.join());
    const job = await get(`/v1/jobs/${made}`);
    expect(job.document.image.width === 120 && job.document.image.height === 96 && job.document.sampling.spp === 4, JSON.stringify(job.document.image));
    expect(job.document.lights.length === wanted.lights.length && job.document.layers.join() === wanted.layers.join(), JSON.stringify(job.document));
    expect((await get("/v1/jobs")).jobs.length === 1, "more than one job");
  });

  await test("an old job is opened in the form, changed and submitted again", async () => {
    await until("the panel", () => page.locator("#again").isVisible());
    await page.click("#again");
    await page.waitForURL(/submit\.html\?job=/);
    await planned();
    expect(await page.inputValue(id("/image/width")) === "120", "another width");
    await page.fill(id("/sampling/seed"), "77");
    await planned();
    await page.locator("#submit").focus();
    await page.keyboard.press("Enter");
    await page.waitForURL(/#\/jobs\/[0-9a-z]{26}$/, { timeout: 15000 });
    expect(page.url().slice(-26) !== made, "the same job");
    const { document } = await get(`/v1/jobs/${page.url().slice(-26)}`);
    expect(document.sampling.seed === 77 && document.image.width === 120, JSON.stringify(document.sampling));
  });

  await test("the form fits a phone and 200 %, without violations", async () => {
    await page.goto(`${url}/submit.html?job=${made}`);
    await planned();
    for (const part of await page.locator("details summary").all()) if (await part.isVisible()) await part.click();
    await page.selectOption(id("/lens"), { label: "thin lens" });
    await page.selectOption(id("/scene/camera"), { label: "eye and target" });
    await planned();
    await narrow(page, "the form", (width) => shot(String(width)));
  });

  await test("a bare scene that is dropped becomes the lit picture of shearwater render", async () => {
    const box = join(tmp, "ball.glb");
    writeFileSync(box, glbOf([{ name: "ball", color: [0.8, 0.4, 0.2], mesh: sphere([1, 2, 3], 1) }]));
    await page.goto(`${url}/submit.html`);
    await until("the form", () => page.locator("#drop").isVisible());
    await drop(box);
    await planned();
    for (const [at, value] of [["/image/width", 96], ["/image/height", 64], ["/sampling/spp", 4]]) await page.fill(id(at), String(value));
    await planned();
    expect(/neutral studio light/.test(await text(page, "warnings")), await text(page, "warnings"));
    await page.click("#submit");
    await page.waitForURL(/#\/jobs\/[0-9a-z]{26}$/, { timeout: 15000 });
    const at = `/v1/jobs/${page.url().slice(-26)}`;
    await until("finished", async () => (await get(at)).state === "finished");
    await until("the picture", async () => (await look(page)).lit > 0.95);
    const ours = join(tmp, "cli.exr"), dropped = join(tmp, "dropped.exr"), program = join(build, "shearwater");
    writeFileSync(dropped, await (await page.request.get(`${url}${at}/frames/1/image.exr`)).body());
    execFileSync(program, ["render", box, "-o", ours, "--size", "96x64", "--spp", "4", "-q"], { stdio: "ignore" });
    const judged = JSON.parse(execFileSync(program, ["compare", ours, dropped], { encoding: "utf8" }));
    expect(judged.max === 0 && Math.min(...judged.mean_test) > 0.15, JSON.stringify(judged));
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/404/.test(line)));
  });

  await test("without a secure context it says so, and takes digests", async () => {
    const other = await openPage(complaints);
    await other.addInitScript(() => Object.defineProperty(globalThis, "isSecureContext", { value: false }));
    await other.goto(`${url}/submit.html`);
    await until("the sentence", async () => /hashes files only for pages from https, 127\.0\.0\.1 or localhost/.test(await other.textContent("#insecure")));
    expect(await other.locator(`${id("/scene/asset")}-file`).isDisabled(), "files can be chosen");
    await other.fill(id("/scene/asset"), digest);
    await until("the plan", async () => /The job is valid/.test(await other.textContent("#said")));
    await clean(other, "the form without hashing");
    await other.close();
  });

  await test("nothing else was written to the console", async () => {
    const others = complaints.filter((line) => !/422/.test(line));
    expect(others.length === 0, others.join("; "));
  });
});

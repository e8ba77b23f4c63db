// Views of light: the page shows a job as its PNG does, and lets data be. TAP on standard output.
//   node tests/browser/view.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { build, expect, openPage, pngBytes, runAll, settle, shots, startServer, submit, test, text, tmp, until, viewText } from "./house.mjs";

const SIZE = 200;
const scene = { file: join(process.cwd(), "tests/scenes/cornell-box/cornell-box.glb") };
const press = async (page, ...keys) => { await page.focus("#stage"); for (const key of keys) await page.keyboard.press(key); };

// The same of the picture on the page, at 1:1.
const shownBytes = (page) => page.evaluate(() => {
  const canvas = document.getElementById("canvas"), [zoom, x, y, width, height] = canvas.dataset.view.split(" ").map(Number);
  if (zoom !== 1) throw new Error(`a zoom of ${zoom}`);
  const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  context.drawImage(canvas, 0, 0);
  return [...context.getImageData(Math.floor(0.5 - x), Math.floor(0.5 - y), width, height).data];
});

// The largest and the mean difference, alpha left out, and how many bytes lie inside the range.
function compare(a, b) {
  expect(a.length === b.length && a.length === SIZE * SIZE * 4, `${a.length} and ${b.length} bytes`);
  let most = 0, sum = 0, inside = 0;
  for (let i = 0; i < a.length; i++) {
    if (i % 4 === 3) continue;
    most = Math.max(most, Math.abs(a[i] - b[i]));
    sum += Math.abs(a[i] - b[i]);
    inside += a[i] > 10 && a[i] < 245;
  }
  return { most, mean: sum / (0.75 * a.length), inside: inside / (0.75 * a.length) };
}

await runAll(async () => {
  const url = await startServer();
  const complaints = [], looks = { linear: 0, filmic: -0.75, agx: 1.5 };
  const page = await openPage(complaints, { viewport: { width: 1400, height: 1000 } });
  const layers = ["beauty", "direct", "albedo", "normal", "error"], jobs = {};
  for (const [view, exposure] of Object.entries(looks))
    jobs[view] = submit(url, { scene, layers, image: { width: SIZE, height: SIZE, view, exposure } });
  jobs.agx_plain = submit(url, { scene, layers, image: { width: SIZE, height: SIZE } });
  const bytesOf = (id, kind) => page.request.get(`${url}/v1/jobs/${id}/frames/1/image.${kind}`).then((answer) => answer.body());
  const png = (id, query = "") => pngBytes(page, `${url}/v1/jobs/${id}/frames/1/image.png${query}`);
  const open = async (id) => {
    await page.goto(`${url}/#/jobs/${id}`);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);
    await until("the picture", async () => (await viewText(page)).endsWith(`${SIZE} ${SIZE}`));
    if (await page.isChecked("#dither")) await press(page, "d");
    await press(page, "1");
    await settle(page, 400);
  };

  for (const [view, exposure] of Object.entries(looks)) {
    await test(`the page opens with the job's view ${view}, and shows what its PNG shows`, async () => {
      await open(jobs[view]);
      expect(await page.inputValue("#curve") === view, `the view ${await page.inputValue("#curve")}`);
      expect(await text(page, "exposure-text") === `${exposure > 0 ? "+" : ""}${exposure} EV`, await text(page, "exposure-text"));
      const { most, mean, inside } = compare(await shownBytes(page), await png(jobs[view]));
      expect(most <= 1 && mean < 0.1 && inside > 0.5, `differs by ${most}, in the mean by ${mean}, ${inside} inside`);
      await page.screenshot({ path: join(shots, `view-${view}.png`), fullPage: true });
    });
  }

  await test("without a word of it a job is seen by AgX", async () => {
    await open(jobs.agx_plain);
    expect(await page.inputValue("#curve") === "agx", await page.inputValue("#curve"));
    const { most } = compare(await shownBytes(page), await png(jobs.agx_plain));
    const { mean } = compare(await png(jobs.agx_plain), await png(jobs.agx_plain, "?view=linear"));
    expect(most <= 1 && mean > 2, `differs by ${most}; from linear by ${mean}`);
  });

  await test("a view that is chosen on the page is that of a query", async () => {
    await open(jobs.linear);
    await page.selectOption("#curve", "agx");
    await press(page, "e", "e", "e", "e");
    await settle(page, 300);
    const { most } = compare(await shownBytes(page), await png(jobs.linear, "?view=agx&exposure=1"));
    expect(most <= 1, `differs by ${most}`);
    await press(page, "0");
    expect(await page.inputValue("#curve") === "linear" && await text(page, "exposure-text") === "0 EV", "reset is not the job's");
  });

  await test("data goes through no view, and keeps an exposure of its own", async () => {
    await open(jobs.agx);
    for (const layer of ["albedo", "normal"]) {
      await page.selectOption("#layer", layer);
      await settle(page, 500);
      const { most, inside } = compare(await shownBytes(page), await png(jobs.agx, `?layer=${layer}`));
      expect(most <= 1 && inside > 0.2, `${layer} differs by ${most}, ${inside} inside`);
      expect(await page.isDisabled("#curve"), `${layer} has a view`);
      expect(await text(page, "exposure-text") === "0 EV", `${layer}: ${await text(page, "exposure-text")}`);
      const same = compare(await png(jobs.agx, `?layer=${layer}`), await png(jobs.linear, `?layer=${layer}&view=filmic`));
      expect(same.most === 0, `${layer} depends on the view: ${same.most}`);
    }
    await page.selectOption("#layer", "direct");
    await settle(page, 500);
    const { most } = compare(await shownBytes(page), await png(jobs.agx, "?layer=direct"));
    expect(most <= 1 && await page.inputValue("#curve") === "agx", `direct differs by ${most}`);
  });

  await test("the command's PNG is the server's, and no view changes the EXR", async () => {
    const file = join(tmp, "agx.json"), at = join(tmp, "agx");
    writeFileSync(file, JSON.stringify({ scene, layers, image: { width: SIZE, height: SIZE }, sampling: { spp: 16 } }));
    execFileSync(join(build, "shearwater"), ["render", file, "-q", "-o", `${at}.exr`, "--png", `${at}.png`, "--view", "agx", "--exposure", "1.5"]);
    expect(readFileSync(`${at}.png`).equals(await bytesOf(jobs.agx, "png")), "another PNG");
    const exr = readFileSync(`${at}.exr`);
    for (const id of Object.values(jobs)) expect(exr.equals(await bytesOf(id, "exr")), "another EXR");
  });

  await test("nothing was complained of", async () => expect(complaints.length === 0, complaints.join("\n")));
});

// Takes README's screenshot of the viewer: a picture under a wipe, without filters on one side of the line.
//   node tests/browser/screenshot.mjs BUILD_DIR
import { mkdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { cornell } from "../bench/scenes/indirect.mjs";
import { light } from "../bench/scenes/light.mjs";
import { openPage, runAll, settle, startServer, submit, text, tmp, until } from "./house.mjs";

const OUT = new URL("../../docs/images/viewer.png", import.meta.url).pathname;
const camera = { eye: [0.037, 0.72, 2.3], target: [0, 0.55, 0], yfov_deg: 38 };
const lamp = light({ center: [0.05, 1.96, 0.1], target: [0.05, 0, 0.1], halfU: 0.32, turn: 0.2, level: [0.8, 0.75, 0.68] });

await runAll(async () => {
  const url = await startServer(0, ["--quiet"]), page = await openPage([], { viewport: { width: 1130, height: 740 } });
  const scene = join(tmp, "box.glb");
  writeFileSync(scene, cornell());
  const job = { scene: { file: scene, camera }, lights: [lamp], effects: { indirect_bounces: 4 }, sampling: { spp: 9 },
    layers: ["beauty", "direct", "indirect", "albedo", "normal", "depth"] };
  const finished = (words) => until("the end", async () => /^100 %/.test(await text(page, "progress-text")) && words.test(await text(page, "figures")), 300);
  for (const image of [{ width: 320, height: 180 }, { width: 640, height: 360 }, { width: 380, height: 258 }]) {
    await page.goto(`${url}/#/jobs/${submit(url, { ...job, image })}`);
    await finished(/^/);
  }
  await page.uncheck("#dither"); // noise that costs bytes
  await page.click("#unfiltered");
  await until("its twin", () => page.inputValue("#other-job"), 60);
  await page.selectOption("#compare", "wipe");
  await page.locator("#wipe-position").fill("79");
  await finished(/RMSE.*in sight$/);
  await until("all jobs' ends", async () => await page.locator("#jobs .state[data-state=finished]").count() === 4);
  for (const id of ["#actual", "#zoom-in"]) await page.click(id); // whole pixels: 200 %
  await page.mouse.move(0, 0); // no button is lit
  await page.evaluate(() => { document.activeElement.blur(); scrollTo(0, 0); });
  await settle(page, 500);
  mkdirSync(dirname(OUT), { recursive: true });
  await page.screenshot({ path: OUT });
});

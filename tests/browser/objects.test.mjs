// Objects of a live job in a photograph are moved in the page, by mouse, keys and numbers, while the
// composite is lit anew. TAP on standard output.
//   node tests/browser/objects.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { encodePicture } from "../bench/scenes/png.mjs";
import { build, expect, openPage, runAll, settle, shots, startServer, submit, test, text, tmp, until } from "./house.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const SIDE = 192;

await runAll(async () => {
  const url = await startServer(), complaints = [];
  const page = await openPage(complaints, { viewport: { width: 1000, height: 900 } });
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"], { origin: url });
  const photograph = join(tmp, "photograph.png");
  writeFileSync(photograph, encodePicture(Buffer.alloc(SIDE * SIDE * 3, 150), SIDE, SIDE));
  // Under a sun and without bounces an object reaches its shadow and no further than filters read.
  const id = submit(url, {
    scene: { file: join(process.cwd(), "tests/scenes/photograph/box.obj"), camera: { eye: [0, 3, 8], target: [0, 0.3, 0], yfov_deg: 40 } },
    image: { width: SIDE, height: SIDE }, effects: { indirect_bounces: 0 }, sampling: { spp: 4 },
    lights: [{ type: "directional", direction: [0.5, -1, -0.3], irradiance: [3, 2.8, 2.5] }],
    backplate: { file: photograph }, catchers: [{ ground: { height: 0 } }], layers: ["composite", "catcher", "backplate"], live: true,
  });
  const api = async () => (await page.request.get(`${url}/v1/jobs/${id}`)).json();
  const moved = async () => (await api()).document.scene.moves;
  const settled = () => until("all moves sent", async () => (await page.getAttribute("#live", "data-settled")) === "true");
  const resting = async () => { await settled(); await until("at rest", async () => (await api()).state === "resting"); };
  const pixel = async (x, y) => {
    const file = join(tmp, "now.exr");
    writeFileSync(file, await (await page.request.get(`${url}/v1/jobs/${id}/frames/1/image.exr`)).body());
    return JSON.parse(execFileSync(join(build, "tests/bench/exr_pixel"), [file, String(x), String(y)]));
  };
  const looks = () => page.evaluate(() => {
    const small = document.createElement("canvas");
    small.width = small.height = 16;
    const to = small.getContext("2d");
    to.drawImage(document.getElementById("canvas"), 0, 0, 16, 16);
    return [...to.getImageData(0, 0, 16, 16).data];
  });
  const apart = (a, b) => a.reduce((most, v, i) => Math.max(most, Math.abs(v - b[i])), 0);
  const stage = page.locator("#stage");
  const drag = async (dx, dy, key) => {
    const { x, y, width, height } = await stage.boundingBox();
    if (key) await page.keyboard.down(key);
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + dx, y + height / 2 + dy, { steps: 6 });
    await page.mouse.up();
    if (key) await page.keyboard.up(key);
    await settled();
  };
  await page.goto(`${url}/#/jobs/${id}`);
  await until("complete", async () => (await text(page, "live-state")) === "complete", 90);

  await test("plate, composite and factor are its layers, and plate and composite stand side by side", async () => {
    const names = await page.$$eval("#layer option", (all) => all.map((one) => one.value));
    expect(names.join() === "beauty,composite,catcher,backplate" && await page.inputValue("#layer") === "composite", names.join());
    await page.selectOption("#compare", "wipe");
    await page.selectOption("#other-layer", "backplate");
    await until("figures", async () => /RMSE/.test(await text(page, "figures")));
    await page.screenshot({ path: join(shots, "plate-and-composite.png") });
    await page.selectOption("#compare", "off");
  });

  await test("without the mode a drag moves the picture alone", async () => {
    await drag(40, 0);
    await page.click("#fit");
    expect((await moved()).length === 0, "an object was moved");
  });

  await test("a drag slides the object along the ground, and the composite changes", async () => {
    await page.click("#object-mode");
    expect(await page.getAttribute("#object-mode", "aria-pressed") === "true" && await page.inputValue("#object") === "box", "the mode is not told");
    await settle(page);
    const before = await looks();
    await drag(80, 0);
    const [{ node, translation, rotation_deg }] = await moved();
    expect(node === "box" && translation[0] > 0.1 && translation[1] === 0 && rotation_deg === 0, JSON.stringify(await moved()));
    await resting();
    await until("another picture", async () => apart(before, await looks()) > 40);
    await page.screenshot({ path: join(shots, "object-moved.png") });
  });

  await test("... while what it does not reach keeps a factor of exactly 1", async () => {
    const corners = [[3, 3], [SIDE - 4, 3], [3, SIDE - 4], [SIDE - 4, SIDE - 4]];
    for (const [x, y] of corners) {
      const at = await pixel(x, y);
      expect(["R", "G", "B"].every((c) => at[`catcher.${c}`] === 1 && at[`composite.${c}`] === at[`backplate.${c}`]), `${x} ${y}: ${JSON.stringify(at)}`);
    }
    const middle = await pixel(SIDE / 2, SIDE / 2);
    expect(middle["catcher.R"] !== undefined && middle["composite.R"] > 0, JSON.stringify(middle));
  });

  await test("with Shift a drag turns it", async () => {
    const [{ translation }] = await moved();
    await drag(50, 0, "Shift");
    const [move] = await moved();
    expect(Math.abs(move.rotation_deg) > 5 && move.translation.join() === translation.join(), JSON.stringify(move));
  });

  await test("keys move, raise, turn and put it back, and say so", async () => {
    await stage.focus();
    await page.keyboard.press("Backspace");
    await settled();
    expect((await moved()).length === 0, "it is not back");
    for (const [key, right] of [["ArrowRight", ({ translation: [x, y, z] }) => x > 0.01 && y === 0 && Math.abs(z) < 1e-6],
      ["ArrowUp", ({ translation: [x, y, z] }) => x > 0.01 && y === 0 && z < -0.01],
      ["Shift+ArrowUp", ({ translation: [, y] }) => y > 0.01], ["Shift+ArrowRight", ({ rotation_deg }) => rotation_deg === 5]]) {
      await page.keyboard.press(key);
      await settled();
      const [move] = await moved();
      expect(right(move), `${key}: ${JSON.stringify(move)}`);
    }
    expect(/^box: moved by .*turned by 5 degrees$/.test(await text(page, "said")), await text(page, "said"));
  });

  await test("numbers in the bar move it, too, and are those that the job has", async () => {
    await page.fill("#object-x", "-0.75");
    await page.keyboard.press("Tab");
    await settled();
    const [move] = await moved();
    expect(move.translation[0] === -0.75 && move.rotation_deg === 5, JSON.stringify(move));
    await page.click("#object-copy");
    await until("copied", async () => (await text(page, "said")) === "moves copied");
    expect(JSON.stringify(JSON.parse(await page.evaluate(() => navigator.clipboard.readText()))) === JSON.stringify(await moved()), "other moves");
    await page.click("#object-back");
    await settled();
    expect((await moved()).length === 0 && await page.inputValue("#object-x") === "0", JSON.stringify(await moved()));
  });

  await test("axe has no complaint, and the mode ends by its key", async () => {
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => axe.run({ runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"] }));
    expect(violations.length === 0, JSON.stringify(violations.map(({ id: rule, nodes }) => [rule, nodes.map(({ html }) => html)])));
    await stage.focus();
    await page.keyboard.press("Escape");
    expect(await page.getAttribute("#object-mode", "aria-pressed") === "false", "still in the mode");
    await page.keyboard.press("Shift+C");
    expect(await page.getAttribute("#object-mode", "aria-pressed") === "true", "the key did not begin it");
    await page.click("#camera-mode");
    expect(await page.getAttribute("#object-mode", "aria-pressed") === "false", "both modes at once");
  });

  await test("nothing was written to the console", () => expect(complaints.length === 0, complaints.join("; ")));
});

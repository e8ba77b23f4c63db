// Objects in photographs on the page: the composite comes first, and its PNG keeps the photograph's bytes.
//   node tests/browser/composite.test.mjs BUILD_DIR
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { encodePicture } from "../bench/scenes/png.mjs";
import { expect, openPage, pngBytes, runAll, startServer, submit, test, text, tmp, until } from "./house.mjs";

const SIDE = 128, COLOR = [150, 110, 70];
const CATCHERS = ["Floor", "Ceiling", "BackWall", "RightWall", "LeftWall"];

await runAll(async () => {
  const url = await startServer(), complaints = [];
  const photograph = join(tmp, "photograph.png");
  writeFileSync(photograph, encodePicture(Buffer.from(Array.from({ length: SIDE * SIDE }, () => COLOR).flat()), SIDE, SIDE));
  const page = await openPage(complaints, { viewport: { width: 1000, height: 800 } });
  // Without bounces the boxes change nothing above them; the lamp is the scene's own.
  const id = submit(url, { image: { width: SIDE, height: SIDE }, sampling: { spp: 4 }, effects: { indirect_bounces: 0 }, layers: undefined,
    backplate: { file: photograph }, catchers: CATCHERS, holdouts: ["Light_emitter_7"] });
  await page.goto(`${url}/#/jobs/${id}`);
  await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);

  await test("the composite is the layer that is shown first", async () => {
    await until("the layer", async () => await page.inputValue("#layer") === "composite");
    const names = await page.$$eval("#layer option", (all) => all.map((one) => one.value));
    expect(names.join() === "beauty,composite,catcher", names.join());
  });

  await test("its PNG has the photograph's bytes where nothing changed, and objects before it", async () => {
    const bytes = await pngBytes(page, `${url}/v1/jobs/${id}/frames/1/image.png`);
    let same = 0;
    for (let i = 0; i < SIDE * SIDE; i++) same += COLOR.every((v, c) => bytes[4 * i + c] === v);
    expect(same > SIDE * SIDE / 8 && same < SIDE * SIDE, `${same} of ${SIDE * SIDE} pixels are the photograph's`);
    const objects = await pngBytes(page, `${url}/v1/jobs/${id}/frames/1/image.png?layer=beauty`);
    expect(objects[0] === 0 && bytes[0] === COLOR[0], `${objects[0]} of the objects, ${bytes[0]} of the composite in a corner`);
  });

  await test("nothing was written to the console", () => expect(complaints.length === 0, complaints.join("; ")));
});

// Hours in front of a render, made short: updates of a real one, layers switched now and then, and
// memory that stays flat. TAP on standard output.
//   node tests/browser/soak.test.mjs BUILD_DIR [SECONDS]
import { readFileSync } from "node:fs";
import { expect, look, openPage, runAll, serverPid, startServer, submit, test, text, until } from "./house.mjs";

const seconds = Number(process.argv[3] ?? 20);
const LAYERS = ["beauty", "direct", "indirect", "albedo"];
const MB = 1e6;
// A browser's process takes minutes to fill its caches: 40 to 80 MB between thirds of half a minute, 8 MB
// between those of 150 s.
const PAGE_BYTES = (seconds >= 150 ? 64 : 160) * MB;
// The coordinator's allocator keeps what its threads gave back: 240 MB after ten frames, 310 after a hundred, and no
// more after that; of it up to 60 MB between thirds of half a minute.
const COORDINATOR_BYTES = (seconds >= 150 ? 64 : 160) * MB;
// Of the page's heap while it shows no job. What it holds else depends on what is shown: a layer's picture has 3.5 MB.
const HEAP_BYTES = 2 * MB;

// Resident memory of a process, in bytes.
const resident = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) * 1024;

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints);
  await page.addInitScript(() => {
    window.counted = { updates: 0, textures: 0 };
    const gl = WebGL2RenderingContext.prototype;
    for (const [name, count] of [["texSubImage2D", (rest) => { counted.updates += Math.ceil(rest[4] / 64) * Math.ceil(rest[5] / 64); }], ["createTexture", () => counted.textures++], ["deleteTexture", () => counted.textures--]]) {
      const own = gl[name];
      gl[name] = function (...rest) { count(rest); return own.apply(this, rest); };
    }
  });
  const session = await page.context().newCDPSession(page);
  const whole = await page.context().browser().newBrowserCDPSession();
  const renderer = async () => {
    const { processInfo } = await whole.send("SystemInfo.getProcessInfo");
    return Math.max(...processInfo.filter(({ type }) => type === "renderer").map(({ id }) => resident(id)));
  };
  const measure = async () => {
    await session.send("HeapProfiler.collectGarbage");
    const { usedSize, backingStorageSize = 0, embedderHeapUsedSize = 0 } = await session.send("Runtime.getHeapUsage");
    return { heap: usedSize + backingStorageSize + embedderHeapUsedSize, page: await renderer(), server: resident(serverPid()),
             ...await page.evaluate(() => counted) };
  };
  // The same state each time: no job is shown, and nothing is on its way.
  const rest = async () => {
    await page.evaluate(() => { location.hash = "#/"; });
    await page.waitForTimeout(500);
    return (await measure()).heap;
  };
  // Few samples and many blocks: as many updates as two workers can bring, one job after the other.
  const begin = () => submit(url, { image: { width: 768, height: 768 }, sampling: { spp: 4, tile_px: 64 }, layers: LAYERS });

  await test(`memory stays flat over ${seconds} s of updates`, async () => {
    let job = begin(), switched = 0;
    await page.goto(`${url}/#/jobs/${job}`);
    await until("pixels", async () => (await look(page)).lit > 0.1, 60);
    const begun = Date.now(), samples = [], rests = [];
    const show = (id) => page.evaluate((id) => { location.hash = `#/jobs/${id}`; }, id);
    while (Date.now() - begun < seconds * 1000) {
      if (Date.now() - begun > (rests.length + 1) * seconds * 1000 / 3) {
        rests.push(await rest());
        await show(job);
      }
      await page.focus("#stage");
      await page.keyboard.press(++switched % 8 === 0 ? "w" : switched % 3 === 0 ? "l" : "e");
      if (switched % 24 === 0) await page.keyboard.press("0");
      await page.waitForTimeout(Math.min(2000, seconds * 25));
      samples.push(await measure());
      if (/finished/.test(await text(page, "progress-text"))) {
        job = begin();
        await show(job);
      }
    }
    rests.push(await rest());
    const { length } = samples, third = Math.floor(length / 3);
    const middle = (from, to, name) => samples.slice(from, to).map((s) => s[name]).sort((a, b) => a - b)[Math.floor((to - from) / 2)];
    const last = samples[length - 1];
    const grown = Object.fromEntries(["page", "server"].map((name) => [name, middle(length - third, length, name) - middle(third, 2 * third, name)]));
    grown.heap = rests.at(-1) - rests.at(-2);
    console.log(`# ${last.updates} blocks drawn; heap without a job after each third ${rests.map((b) => (b / MB).toFixed(2)).join(", ")} MB; from the `
      + `second third to the last: page's process ${(grown.page / MB).toFixed(1)} MB, coordinator ${(grown.server / MB).toFixed(1)} MB; `
      + `at the end ${(last.heap / MB).toFixed(1)}, ${(last.page / MB).toFixed(0)}, ${(last.server / MB).toFixed(0)} MB`);
    expect(rests.length === 3, `${rests.length} rests`);
    expect(last.updates > seconds * 20, `only ${last.updates} updates`);
    expect(last.textures <= 2 + 7, `${last.textures} textures`);
    expect(grown.heap < HEAP_BYTES, `the page's heap grew by ${grown.heap} bytes`);
    expect(grown.page < PAGE_BYTES, `the page's process grew by ${grown.page} bytes`);
    expect(grown.server < COORDINATOR_BYTES, `the coordinator grew by ${grown.server} bytes`);
    expect(complaints.length === 0, complaints.join("; "));
    await page.request.delete(`${url}/v1/jobs/${job}`);
  });
});

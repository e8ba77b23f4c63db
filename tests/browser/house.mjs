// What the browser tests share: TAP, a real coordinator with two workers, Debian's Chromium.
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

export const build = resolve(process.argv[2] ?? "build");
export const shots = join(build, "screenshots");
export const tmp = mkdtempSync(join(tmpdir(), "shearwater-browser-"));
const scene = resolve("tests/scenes/cornell-box/cornell-box.glb");
let server, browser, count = 0, failed = 0;
mkdirSync(shots, { recursive: true });

export async function test(text, run) {
  count++;
  try {
    await run();
    console.log(`ok ${count} - ${text}`);
  } catch (error) {
    failed++;
    console.log(`not ok ${count} - ${text}`);
    for (const line of String(error.stack ?? error).split("\n")) console.log(`#   ${line}`);
  }
}

export function expect(condition, text) { if (!condition) throw new Error(text); }

// How long it may take is no bound of what is awaited: the machine may be busy. Bounds are measured.
export async function until(what, read, seconds = 60, seen = async () => "") {
  const end = Date.now() + seconds * 1000;
  let last;
  while (Date.now() < end) {
    last = await read();
    if (last) return last;
    await new Promise((done) => setTimeout(done, 50)); // each look keeps two processes of the browser busy
  }
  throw new Error(`${what}: not within ${seconds} s ${await seen()}`);
}

// The view, "ZOOM X Y WIDTH HEIGHT", when all that was pressed is drawn; a page just opened has drawn none.
export async function viewText(page) {
  await settle(page);
  return until("a drawing", () => page.getAttribute("#canvas", "data-view"));
}

// Until what was asked for is drawn, on a busy machine, too: drawings are made in animation frames.
export async function settle(page, ms = 100) {
  await page.waitForTimeout(ms);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
}

export function startServer(port = 0, options = []) {
  server = spawn(join(build, "shearwater"),
    ["serve", "--listen", `127.0.0.1:${port}`, "--data", join(tmp, "data"), "--workers", "2", ...options],
    { stdio: ["ignore", "pipe", "inherit"] });
  return new Promise((done, fail) => {
    let text = "";
    server.stdout.on("data", (chunk) => {
      text += chunk;
      const url = /listening on (\S+)/.exec(text)?.[1];
      if (url) done(url);
    });
    server.on("exit", (code) => fail(new Error(`the server ended with ${code}`)));
  });
}

export const serverPid = () => server.pid;

export function stopServer(signal = "SIGTERM") {
  return new Promise((done) => {
    server.removeAllListeners("exit");
    server.on("exit", done);
    server.kill(signal);
  });
}

export function submit(url, changes) {
  const job = {
    scene: { file: scene }, image: { width: 320, height: 320 }, sampling: { spp: 16 },
    layers: ["beauty", "direct", "indirect", "albedo", "normal", "depth"], ...changes,
  };
  const file = join(tmp, "job.json");
  writeFileSync(file, JSON.stringify(job));
  return execFileSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"]).toString().trim();
}

// A page in Chromium; what it writes to the console as errors is added to `complaints`.
export async function openPage(complaints, options = {}) {
  browser ??= await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--enable-precise-memory-info", "--js-flags=--expose-gc",
           "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run", "--disable-quic"],
  });
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 }, ...options });
  page.on("console", (message) => { if (message.type() === "error") complaints.push(message.text()); });
  page.on("pageerror", (error) => complaints.push(String(error)));
  return page;
}

// Of the picture on the canvas: the share of it that is not black, and its mean.
export const look = (page) => page.evaluate(() => {
  const canvas = document.getElementById("canvas");
  const [zoom, x, y, width, height] = (canvas.dataset.view ?? "1 0 0 0 0").split(" ").map(Number);
  const left = Math.max(0, -x * zoom), top = Math.max(0, -y * zoom);
  const wide = Math.floor(Math.min(canvas.width - left, width * zoom)), tall = Math.floor(Math.min(canvas.height - top, height * zoom));
  if (!canvas.width || wide < 1 || tall < 1) return { lit: 0, mean: 0 };
  const copy = document.createElement("canvas");
  copy.width = wide;
  copy.height = tall;
  const context = copy.getContext("2d");
  context.drawImage(canvas, left, top, wide, tall, 0, 0, wide, tall);
  const { data } = context.getImageData(0, 0, wide, tall);
  let lit = 0, sum = 0;
  for (let i = 0; i < data.length; i += 4) {
    const value = data[i] + data[i + 1] + data[i + 2];
    lit += value > 6; // dither is no light
    sum += value / 3;
  }
  return { lit: lit / (data.length / 4), mean: sum / (data.length / 4) };
});
// For who waited for it in vain.
export const canvasText = async (page) => JSON.stringify({ ...await look(page), ...await page.evaluate(async () => {
  const canvas = document.getElementById("canvas"), { width, height, dataset } = canvas, late = new Promise((done) => setTimeout(done, 2000, "no frames"));
  return { width, height, view: dataset.view, lost: canvas.getContext("webgl2")?.isContextLost(), note: document.getElementById("canvas-note").textContent,
    frames: await Promise.race([new Promise((done) => requestAnimationFrame(() => done("frames"))), late]) };
}) });

// The bytes of a PNG as the browser decodes it, four a pixel.
export const pngBytes = (page, url) => page.evaluate(async (address) => {
  const bitmap = await createImageBitmap(await (await fetch(address)).blob(), { premultiplyAlpha: "none", colorSpaceConversion: "none" });
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
}, url);

export const text = (page, id) => page.textContent(`#${id}`);

// Runs all tests, says how they went, and ends.
export async function runAll(tests) {
  try {
    await tests();
  } catch (error) {
    count++;
    failed++;
    console.log(`not ok ${count} - the tests ran to their end`);
    console.log(`#   ${error.stack ?? error}`);
  } finally {
    await browser?.close();
    if (server?.exitCode === null) await stopServer();
    rmSync(tmp, { recursive: true, force: true });
  }
  console.log(`1..${count}`);
  process.exit(failed ? 1 : 0);
}

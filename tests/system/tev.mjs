// shearwater watch --tev, against a scripted tev: packets as documented, pixels as in the EXR.
//   node tests/system/tev.mjs BUILD_DIR
import { execFile, execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { readExr } from "../../web/picture/exr_file.js";
import { FakeTev } from "../fake/tev.mjs";

const slower = Number(process.env.TEST_SLOWER ?? 1); // of builds with sanitizers (tests/run)
const shearwater = join(resolve(process.argv[2] ?? "build"), "shearwater"), tmp = mkdtempSync(join(tmpdir(), "shearwater-tev-"));
let count = 0, failed = 0;
const expect = (condition, text) => { if (!condition) throw new Error(text); };
async function test(text, run) {
  count++;
  try { await run(); console.log(`ok ${count} - ${text}`); } catch (error) {
    failed++;
    console.log(`not ok ${count} - ${text}\n#   ${String(error.stack).split("\n").join("\n#   ")}`);
  }
}
const run = (...args) => new Promise((done) => execFile(shearwater, args, { timeout: 120000 * slower }, (error, out, complaint) => done({ code: error ? error.code ?? 1 : 0, complaint })));

const server = spawn(shearwater, ["serve", "--listen", "127.0.0.1:0", "--data", join(tmp, "data"), "--workers", "2"], { stdio: ["ignore", "pipe", "ignore"], env: { ...process.env, SHEARWATER_LIVE_IDLE_MS: "2000" } });
const url = await new Promise((done) => server.stdout.on("data", (chunk) => { const found = /listening on (\S+)/.exec(String(chunk)); if (found) done(found[1]); }));
function submit(changes) {
  const camera = { eye: [0.3, 1.2, 6], target: [0, 1, 0], up: [0, 1, 0], yfov_deg: 30 }, file = join(tmp, "job.json");
  writeFileSync(file, JSON.stringify({ scene: { file: resolve("tests/scenes/cornell-box/cornell-box.glb"), camera }, image: { width: 150, height: 130 },
    sampling: { spp: 16 }, filter: { method: "none" }, layers: ["depth", "beauty", "normal", "albedo", "id"], ...changes }));
  return execFileSync(shearwater, ["submit", file, "--server", url, "--quiet"]).toString().trim();
}
async function equal(tev, job, layers) {
  const { buffer, byteOffset, byteLength } = readFileSync(join(tmp, `${job}.exr`));
  const exr = await readExr(buffer.slice(byteOffset, byteOffset + byteLength)), image = tev.images.get(`shearwater ${job}`);
  for (const name of exr.channels.keys()) if (/\d\d\.[RGBA]$/.test(name)) exr.channels.delete(name); // ids, which feeds do not bring
  expect(tev.faults.length === 0, tev.faults.slice(0, 3).join("; "));
  expect(image && image.width === exr.width && image.height === exr.height, `${[...tev.images.keys()]}, ${image?.width} x ${image?.height}`);
  expect([...image.channels.keys()].sort().join() === [...exr.channels.keys()].sort().join(), `channels ${[...image.channels.keys()]}, the file has ${[...exr.channels.keys()]}`);
  for (const [name, values] of exr.channels) {
    const off = values.findIndex((v, i) => v !== image.channels.get(name)[i]);
    expect(off < 0, `${name}, pixel ${off}: ${image.channels.get(name)[off]}, the file has ${values[off]}`);
  }
  expect(layers === undefined || exr.channels.size === layers, `${exr.channels.size} channels`);
}
const watch = (job, port, ...more) => run("watch", job, "--server", url, "--quiet", "-o", join(tmp, `${job}.exr`), "--tev", `127.0.0.1:${port}`, ...more);

try {
  await test("a finished job: every channel as in the EXR but ids of compositors, alpha too", async () => {
    const tev = new FakeTev(), port = await tev.listen(), job = submit({ layers: ["depth", "beauty", "normal", "albedo", "id", "CryptoObject"] });
    expect((await run("watch", job, "--server", url, "--quiet")).code === 0, "the job does not finish");
    const { code, complaint } = await watch(job, port);
    expect(code === 0, complaint);
    await equal(tev, job, 15);
    const alpha = tev.images.get(`shearwater ${job}`).channels.get("A");
    expect(alpha.includes(0) && alpha.includes(1) && tev.created === 1, `${tev.created} images`);
    await tev.close();
  });

  await test("a job that renders: what comes at last is the picture", async () => {
    const tev = new FakeTev(), port = await tev.listen(), job = submit({ sampling: { spp: Math.ceil(64 / slower) }, image: { width: 300, height: 300 }, layers: ["beauty", "depth"] });
    const { code, complaint } = await watch(job, port);
    expect(code === 0, complaint);
    await equal(tev, job);
    expect(tev.updates > 50, `${tev.updates} updates: none while it rendered`);
    await tev.close();
  });

  await test("a tev that is closed and started again is shown all of it", async () => {
    const tev = new FakeTev(), port = await tev.listen(), job = submit({ sampling: { spp: Math.ceil(96 / slower) }, image: { width: 300, height: 300 }, layers: ["beauty"] });
    const done = watch(job, port);
    const end = Date.now() + 30000 * slower;
    while (tev.updates === 0 && Date.now() < end) await new Promise((again) => setTimeout(again, 20));
    await tev.close();
    const another = new FakeTev();
    await new Promise((again) => setTimeout(again, 700));
    await another.listen(port);
    const { code, complaint } = await done;
    expect(code === 0, complaint);
    await equal(another, job);
    await another.close();
  });

  await test("a live job of several layers is one image, of its full size", async () => {
    const tev = new FakeTev(), port = await tev.listen(), job = submit({ live: true, sampling: { spp: 16 }, image: { width: 640, height: 360 }, layers: ["beauty", "depth", "normal"] });
    const { code, complaint } = await watch(job, port);
    expect(code === 0, complaint);
    await equal(tev, job);
    expect(tev.created === 1, `${tev.created} images`);
    await tev.close();
  });

  await test("a peer that only hangs up is not called all the time", async () => {
    let calls = 0;
    const peer = createServer((socket) => { calls++; socket.on("error", () => {}); socket.destroy(); });
    await new Promise((done) => peer.listen(0, "127.0.0.1", done));
    const job = submit({ sampling: { spp: Math.ceil(64 / slower) }, image: { width: 200, height: 200 }, layers: ["beauty"] });
    const watching = spawn(shearwater, ["watch", job, "--server", url, "--quiet", "--tev", `127.0.0.1:${peer.address().port}`], { stdio: "ignore" });
    await new Promise((done) => setTimeout(done, 2000));
    watching.kill();
    peer.close();
    expect(calls > 1 && calls < 12, `${calls} calls within 2 s`);
  });

  await test("a slow tev gets the newest", async () => {
    const tev = new FakeTev(), port = await tev.listen(0, 5), job = submit({ sampling: { spp: 64 }, image: { width: 200, height: 200 }, layers: ["beauty"] });
    const { code, complaint } = await watch(job, port);
    expect(code === 0, complaint);
    await new Promise((again) => setTimeout(again, 500));
    await equal(tev, job);
    await tev.close();
  });

  await test("nobody listens, other machines, and what is no address are said", async () => {
    const tev = new FakeTev(), port = await tev.listen(), job = submit({ image: { width: 16, height: 16 } });
    await tev.close();
    const silent = await watch(job, port);
    expect(silent.code === 1 && silent.complaint.includes(`no tev listens at 127.0.0.1:${port}`), silent.complaint);
    const far = await run("watch", job, "--server", url, "--quiet", "--tev", "192.0.2.1:14158");
    expect(far.code === 1 && /192\.0\.2\.1 is not this machine.*--tev-anywhere/.test(far.complaint), far.complaint);
    for (const [text, said] of [["tev", /"tev" is not HOST:PORT/], ["127.0.0.1:", /is not HOST:PORT/], ["127.0.0.1:70000", /70000 is no port/], ["127.0.0.1:1a", /is not HOST:PORT/]]) {
      const bad = await run("watch", job, "--server", url, "--quiet", "--tev", text);
      expect(bad.code === 1 && said.test(bad.complaint), bad.complaint);
    }
  });
} finally {
  server.kill();
  rmSync(tmp, { recursive: true, force: true });
}
console.log(`1..${count}`);
process.exit(failed ? 1 : 0);

// A farm that is pre-empted: of ten workers one is killed every few seconds and comes back as another, as spot
// machines and preemptible queues have it. A frame of a thousand tiles is done all the same, once, with the bytes of
// an undisturbed one.
//   node tests/load/preempt.mjs BUILD_DIR [tiles=1024] [workers=10] [every_s=5] [seed=N]
import { spawn } from "node:child_process";
import { Service, check, done, folder, join, note, options, readFileSync, seeded, sha256, until } from "./service.mjs";

const build = process.argv[2], TILE_PX = 32;
const want = options({ tiles: 1024, workers: 10, every_s: 5, seed: Math.floor(Date.now() / 1000) % 1000000 });
note(`seed ${want.seed}`);
const random = seeded(want.seed), glb = readFileSync("tests/scenes/cornell-box/cornell-box.glb");
const side = TILE_PX * Math.ceil(Math.sqrt(want.tiles));
const service = new Service(build, join(folder("preempt"), "data"), { workers: 0 });

// ---- workers that somebody else owns ----

const farm = [];
let hired = 0;
const hire = () => {
    const child = spawn(join(build, "shearwater-worker"), ["--connect", `unix:${join(service.data, "worker.sock")}`, "--threads", "1",
        "--name", `spot-${++hired}`], { stdio: "ignore" });
    farm.push(child);
};
process.on("exit", () => farm.forEach((child) => child.kill("SIGKILL")));
const preempt = () => {
    farm.splice(random(farm.length), 1)[0].kill("SIGKILL");
    hire();
};

// ---- frames ----

const frame = async (seconds) => {
    const { status, body } = await service.post({ scene: { asset: sha256(glb) }, image: { width: side, height: side },
        sampling: { spp: 64, tile_px: TILE_PX, seed: 7 }, filter: { method: "none" }, effects: { indirect_bounces: 3 } });
    if (status !== 202) throw new Error(`the job was not accepted: ${status} ${body}`);
    const id = JSON.parse(body).id;
    const ended = await until(seconds, async () => ["finished", "failed"].includes((await service.job(id))?.state), 100);
    const job = await service.job(id);
    return { state: ended ? job.state : `still ${job.state}`, tiles: job.progress.tiles_total, why: job.error ?? "", bytes: sha256(await service.picture(id) ?? "") };
};

await service.start();
await service.put(glb);
for (let i = 0; i < want.workers; i++) hire();
const calm = await frame(600);
check("an undisturbed frame is done", calm.state === "finished", calm);
let kills = 0;
const storm = setInterval(() => { preempt(); kills++; }, 1000 * want.every_s);
const disturbed = await frame(1200);
clearInterval(storm);
check(`so is one of ${disturbed.tiles} tiles while workers are killed`, disturbed.state === "finished", disturbed);
check(`one at least was, ${kills} in all`, kills > 0, "the frame is too quick: ask for more tiles");
check("it has as many tiles as were asked for", disturbed.tiles >= want.tiles, disturbed);
check("its bytes are those of the undisturbed one", disturbed.bytes === calm.bytes, [calm, disturbed]);
farm.forEach((child) => child.kill("SIGKILL"));
await service.kill("SIGTERM");
done();

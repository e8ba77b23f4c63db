// How soon a coordinator that was killed serves again when many jobs wait.
//   node tests/load/ready.mjs BUILD_DIR [jobs=10000] [limit_ms=2000] [runs=3]
// The jobs go in by the real API; nobody works on them, so that all wait. Ready is: readyz says so, the
// newest page of jobs is there, and a submission is accepted, all since the start of the process.
import { Service, check, done, figure, folder, join, note, options, readFileSync, sleep } from "./service.mjs";

const build = process.argv[2], want = options({ jobs: 10000, limit_ms: 2000, runs: 3 });
const scene = readFileSync("tests/scenes/cornell-box/cornell-box.glb");
const service = new Service(build, join(folder("ready"), "data"), { workers: 0 });

const document_of = (asset, i) => ({
    scene: { asset }, image: { width: 320 + i % 7, height: 240 }, sampling: { spp: 16, seed: i },
    effects: { indirect_bounces: 2 }, priority: i % 5,
    layers: ["beauty", "direct", "indirect", "albedo", "normal", "depth"],
});

// 64 at a time: the store makes a commit for all that wait.
const submit_all = async (asset) => {
    let next = 0, accepted = 0;
    const client = async () => {
        while (next < want.jobs) {
            const i = next++, answer = await service.post(document_of(asset, i), `ready-${i}`);
            accepted += answer.status === 202;
        }
    };
    const begin = performance.now();
    await Promise.all(Array.from({ length: 64 }, client));
    note(`${want.jobs} jobs submitted, ${Math.round(1000 * want.jobs / (performance.now() - begin))} a second`);
    return accepted;
};

const resident_mb = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;

await service.start();
const asset = JSON.parse((await service.put(scene)).body).sha256;
check(`${want.jobs} jobs are accepted`, await submit_all(asset) === want.jobs);
const times = [];
for (let run = 0; run < want.runs; run++) {
    await sleep(300);
    await service.kill();
    const begin = performance.now(), listening_ms = await service.start();
    const ready = await service.ask("GET", "/readyz"), page = await service.json("/v1/jobs?limit=100");
    const again = await service.post(document_of(asset, run), `after-${run}`);
    const ms = performance.now() - begin;
    times.push(ms);
    note(`run ${run + 1}: listens after ${listening_ms.toFixed(0)} ms, has served after ${ms.toFixed(0)} ms; ${resident_mb(service.pid).toFixed(0)} MB resident`);
    check("... it says that it is ready, or that it lacks only workers", ready.status === 200 || JSON.parse(ready.body).type.endsWith("no-worker"), String(ready.body));
    check("... lists the newest", page?.jobs.length === 100);
    check("... and accepts another", again.status === 202, String(again.body));
}
const worst = Math.max(...times);
figure(`ready within ${want.limit_ms} ms with ${want.jobs} jobs queued: ${worst.toFixed(0)} ms at most`, worst <= want.limit_ms);
// A job that goes from state to state between two looks would count twice.
const waiting = (await service.metrics(...["queued", "running", "importing"].map((state) => `shearwater_jobs{state="${state}"}`)))
    .reduce((sum, n) => sum + n, 0);
check("none of them is lost", waiting === want.jobs + want.runs, `${waiting} wait`);
await service.kill();
done();

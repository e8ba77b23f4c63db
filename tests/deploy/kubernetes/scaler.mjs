// What KEDA and a Deployment do together, with processes for pods: asks /v1/stats, starts a worker for each `threads`
// threads that are wanted, up to `most`, and sends SIGTERM to those that are too many for `cooldown_s`. With kill_s, every
// so many seconds a tenth of the workers is killed, one at least. Tells on standard output what it does.
//   scaler.mjs URL threads=2 most=4 cooldown_s=2 [kill_s=5] [token=T] -- WORKER ARGUMENTS...
import { spawn } from "node:child_process";

const split = process.argv.indexOf("--"), [program, ...options] = process.argv.slice(split + 1);
const url = process.argv[2], set = Object.fromEntries(process.argv.slice(3, split).map((word) => word.split("=")));
const workers = new Set(); // in the order of their starts
const start_ms = Date.now();
let calm_since_ms = start_ms, number = 0, stopping = false;
const untold = () => [...workers].filter((worker) => !worker.told);
const tell = (what) => console.log(`${((Date.now() - start_ms) / 1000).toFixed(2)} ${what}`);

function start() {
  const name = `worker-${++number}`, child = spawn(program, options, { env: { ...process.env, POD_NAME: name }, stdio: ["ignore", "ignore", "inherit"] });
  workers.add(child);
  child.on("exit", (status, signal) => { workers.delete(child); tell(`${name} ended ${signal ?? status}, ${workers.size} are left`); });
  tell(`${name} started, there are ${workers.size}`);
}
function end(chosen, signal) {
  for (const child of chosen) { child.told = true; child.kill(signal); }
}
async function look() {
  const headers = set.token ? { Authorization: `Bearer ${set.token}` } : {};
  const { threads_wanted } = await (await fetch(`${url}/v1/stats`, { headers })).json();
  const wanted = Math.min(Number(set.most), Math.ceil(threads_wanted / Number(set.threads)));
  const there = untold().length;
  if (wanted >= there) calm_since_ms = Date.now();
  for (let i = there; i < wanted; i++) start();
  if (Date.now() - calm_since_ms >= 1000 * Number(set.cooldown_s)) end(untold().slice(wanted), "SIGTERM");
}
async function run() {
  while (!stopping) {
    await look().catch((error) => tell(`no answer: ${error.message}`));
    await new Promise((resolve) => setTimeout(resolve, 250));
  }
}
if (set.kill_s) setInterval(() => end(untold().slice(0, Math.ceil(workers.size / 10)), "SIGKILL"), 1000 * Number(set.kill_s)).unref();
process.on("SIGTERM", () => { stopping = true; end(untold(), "SIGTERM"); });
run();

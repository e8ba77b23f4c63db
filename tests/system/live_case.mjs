// What the tests of live jobs share: TAP on standard output, and how they ask.
import { ask } from "./live_feed.mjs";

const [url] = process.argv.slice(2);
let count = 0, failed = 0;
export const slower = Number(process.env.TEST_SLOWER ?? 1); // of builds with sanitizers (tests/run)

export async function test(text, run) {
  count++;
  try { await run(); console.log(`ok ${count} - ${text}`); } catch (error) {
    failed++;
    console.log(`not ok ${count} - ${text}\n#   ${String(error.stack).split("\n").slice(0, 4).join("\n#   ")}`);
  }
}
export function expect(condition, text) { if (!condition) throw new Error(text); }
export const pause = (ms) => new Promise((done) => setTimeout(done, ms));
export const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

export const get = async (id) => (await ask("GET", `${url}/v1/jobs/${id}`)).body;
export const move = (id, change) => ask("PATCH", `${url}/v1/jobs/${id}`, change);
export async function reach(id, state, seconds = 60) {
  const end = performance.now() + seconds * 1000 * slower;
  for (let job; ; await pause(20)) {
    job = await get(id);
    if (job.state === state) return job;
    if (performance.now() > end || job.error) throw new Error(`${id} is ${job.state}, not ${state}: ${JSON.stringify(job.error)}`);
  }
}

export function end() {
  console.log(`1..${count}`);
  process.exit(failed ? 1 : 0);
}

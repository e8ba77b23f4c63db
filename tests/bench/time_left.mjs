// How right the time left is told of jobs with a target, on the scenes of the peers folder, from the tenth per cent of the
// time on: of ranges, how many have what was truly left; of times, how many are within a third of it (tests/system/eta.mjs).
//   time_left.mjs BUILD [scene=NAME,...] [method=none,auto] [peers=DIR] [print=1]
// One JSON line a job. Other work on the machine changes what is right: let it rest. Status 1 when BOUNDS do not hold.
import { spawnSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { ownServer } from "../load/own_server.mjs";
import { follow } from "../system/eta.mjs";
import { peersFolder } from "./folders.mjs";
import { peersScenes } from "./scenes/peers.mjs";

// Jobs of five to sixty seconds.
const TARGETS = {
  cornell: { none: [0.06], auto: [0.02] }, living_room: { none: [0.1], auto: [0.1, 0.04] }, veach_mis: { none: [1.5], auto: [0.4] },
  helmet_studio: { none: [0.08], auto: [0.08] }, helmet_park: { auto: [0.04] }, spheres_venice: { none: [0.05], auto: [0.04] },
  blocks: { none: [0.01], auto: [0.006] }, blocks_sky: { none: [0.03], auto: [0.009] } };
const BOUNDS = { within: 0.95, told: 0.6, right: 0.98 };

const [build = "", ...words] = process.argv.slice(2);
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const scenes = peersScenes(peersFolder(given.peers));
if (!build || !scenes) {
  console.error(build ? "time_left: there is no folder of peers" : "usage: time_left.mjs BUILD [scene=NAME,...] [method=none,auto] [peers=DIR]");
  process.exit(2);
}

const { url, server, folder } = await ownServer(build, "eta");

async function judge(scene, method, target) {
  const file = join(folder, "job.json");
  writeFileSync(file, JSON.stringify({ ...scene.job, sampling: { spp: 4, seed: 1, target_error: target }, filter: { method } }));
  const sent = spawnSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"], { encoding: "utf8" });
  if (sent.status !== 0) throw new Error(sent.stderr);
  const told = await follow(url, sent.stdout.trim(), given.print);
  const { statistics } = await (await fetch(`${url}/v1/jobs/${sent.stdout.trim()}`)).json();
  return { scene: scene.name, method, target, ...told, ...statistics.target };
}

const sum = { events: 0, ranged: 0, within: 0, told: 0, right: 0 };
for (const scene of scenes)
  for (const method of given.method?.split(",") ?? ["none", "auto"])
    for (const target of (given.scene?.split(",").includes(scene.name) ?? true) ? TARGETS[scene.name]?.[method] ?? [] : []) {
      const line = await judge(scene, method, target);
      for (const name of Object.keys(sum)) sum[name] += line[name];
      console.log(JSON.stringify(line));
    }
console.error(`of ${sum.events} events ${sum.ranged} told a range, of which ${sum.within} had what was left, and ${sum.told} a time, of which ${sum.right} were right within a third; bounds ${JSON.stringify(BOUNDS)}`);
server.kill("SIGTERM");
await new Promise((done) => server.on("exit", done));
process.exit(sum.ranged === sum.events && sum.within >= BOUNDS.within * sum.ranged && sum.told >= BOUNDS.told * sum.events && sum.right >= BOUNDS.right * sum.told ? 0 : 1);

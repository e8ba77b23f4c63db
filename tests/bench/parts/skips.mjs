// What a frame does not need is neither traced nor sent: for each kind of skip pairs of frames that differ in
// the need alone, and what is saved where it is not there. Counters and plans say that the skip is what did it.
import { writeFileSync } from "node:fs";
import { Farm } from "../farm.mjs";
import { glbOf } from "../scenes/glb.mjs";
import { light } from "../scenes/light.mjs";
import { box, floor, join, quad, stick } from "../scenes/mesh.mjs";
import { raysOf, repeated } from "./runs.mjs";

const GREY = [0.6, 0.6, 0.6], BLACK = [0, 0, 0], RED = [0.7, 0.25, 0.2];
const above = { eye: [0, 8, 0.01], target: [0, 0, 0], yfov_deg: 50 };
const lamp = (x = 0) => light({ center: [x, 6, 1], target: [0, 0, 0], halfU: 0.6, turn: 0.3 });
const turnedAway = { ...lamp(1), half_u: lamp(1).half_v, half_v: lamp(1).half_u };
const bulb = { type: "point", position: [0.5, 4, 1], intensity: [60, 60, 60] };

// A floor, and sticks above it at the given places.
const sticks = (places, color = GREY) => glbOf([{ name: "floor", color, mesh: floor(6) },
  ...(places.length > 0 ? [{ name: "sticks", color: RED, mesh: join(places.map(([x, z]) => stick([x, 0.9, z], [x + 0.3, 1, z + 0.2], 0.05))) }] : [])]);
const everywhere = Array.from({ length: 169 }, (_, i) => [-3.9 + 0.65 * (i % 13), -3.9 + 0.65 * Math.floor(i / 13)]);
const corner = everywhere.filter(([x, z]) => x < -2.9 && z < -2.9);
const slab = (half) => glbOf([{ name: "floor", color: GREY, mesh: quad([-half, 0, -6], [0, 0, 12], [2 * half, 0, 0]) }]);
const room = () => glbOf([{ name: "floor", color: GREY, mesh: floor(6) }, { name: "boxes", color: RED, mesh: join([box([-2, 0, -1], [-1, 1.2, 0]), box([0.5, 0, 0.5], [1.5, 0.6, 1.5])]) }]);

const job = (more = {}) => ({ lights: [lamp()], camera: above, effects: { indirect_bounces: 0 }, sampling: { spp: 9, seed: 1 }, layers: ["beauty"], ...more });

// need, spare: {glb, job}, with the need and without. holds: what must be, [frame, member, relation, value], where
// "skipped X" is a sentence of the plan's. saves: what must fall, of rays and bytes. about: the difference.
export const PAIRS = [
  { skip: "effect", name: "lens", about: "an aperture, and one of size 0", saves: ["rays", "bytes"],
    need: { glb: room, job: job({ lens: { aperture_radius: 0.05, focus_distance: 7 } }) }, spare: { glb: room, job: job({ lens: { aperture_radius: 0, focus_distance: 7 } }) },
    holds: [["need", "rays.lens", ">", 0], ["spare", "rays.lens", "==", 0], ["spare", "skipped effect lens", "==", true], ["need", "skipped effect lens", "==", false]] },
  { skip: "effect", name: "indirect light", about: "lights that shine, and black ones", saves: ["rays", "bytes"],
    need: { glb: room, job: job({ effects: { indirect_bounces: 1 } }) }, spare: { glb: room, job: job({ lights: [{ ...lamp(), radiance: [0, 0, 0] }], effects: { indirect_bounces: 1 } }) },
    holds: [["need", "rays.indirect", ">", 0], ["spare", "rays.indirect", "==", 0], ["spare", "skipped effect indirect", "==", true], ["need", "skipped effect indirect", "==", false]] },
  { skip: "light", name: "a second light", about: "towards the scene, and turned away from it", saves: ["rays", "bytes"],
    need: { glb: room, job: job({ lights: [lamp(), lamp(1)] }) }, spare: { glb: room, job: job({ lights: [lamp(), turnedAway] }) },
    holds: [["spare", "skipped light /lights/1", "==", true], ["need", "skipped light /lights/1", "==", false]] },
  { skip: "block", name: "shadow filter", about: "shadows all over, and in a corner", saves: ["bytes"],
    need: { glb: () => sticks(everywhere), job: job() }, spare: { glb: () => sticks(corner), job: job() },
    holds: [["need", "filters.shadow.blocks_skipped", "==", 0], ["spare", "filters.shadow.blocks_skipped", ">", 0]] },
  { skip: "block", name: "indirect filter", about: "surfaces all over, and in a strip", saves: ["rays", "bytes"],
    need: { glb: () => slab(6), job: job({ effects: { indirect_bounces: 1 } }) }, spare: { glb: () => slab(0.4), job: job({ effects: { indirect_bounces: 1 } }) },
    holds: [["need", "filters.indirect.blocks_skipped", "==", 0], ["spare", "filters.indirect.blocks_skipped", ">", 0]] },
  { skip: "pixel", name: "background", about: "surfaces all over, and on half of the picture", saves: ["rays"],
    need: { glb: () => slab(6), job: job() }, spare: { glb: () => slab(1.8), job: job() },
    holds: [["need", "skipped.background", "==", 0], ["spare", "skipped.background", ">", 0]] },
  { skip: "pixel", name: "in focus", about: "a floor out of focus, and in focus", saves: [],
    need: { glb: () => sticks([]), job: job({ lens: { aperture_radius: 0.1, focus_distance: 4 } }) }, spare: { glb: () => sticks([]), job: job({ lens: { aperture_radius: 0.1, focus_distance: 8 } }) },
    holds: [["need", "filters.lens.pixels_skipped", "==", 0], ["spare", "filters.lens.pixels_skipped", ">", 0]] },
  { skip: "plane", name: "of nothing but defaults", about: "shadows all over, and none", saves: ["bytes"],
    need: { glb: () => sticks(everywhere), job: job() }, spare: { glb: () => sticks([]), job: job() },
    holds: [["need", "skipped.empty_plane", "==", 0], ["spare", "skipped.empty_plane", ">", 0]] },
  { skip: "plane", name: "that nobody reads", about: "errors asked for, and not", saves: ["bytes"],
    need: { glb: room, job: job({ lights: [bulb], effects: { indirect_bounces: 1 }, layers: ["beauty", "error"] }) }, spare: { glb: room, job: job({ lights: [bulb], effects: { indirect_bounces: 1 } }) },
    holds: [["spare", "skipped plane indirect_halves", "==", true], ["need", "skipped plane indirect_halves", "==", false]] },
  { skip: "ray", name: "black surfaces", about: "a grey floor, and a black one", saves: ["rays", "bytes"],
    need: { glb: () => sticks(corner), job: job({ effects: { indirect_bounces: 1 } }) }, spare: { glb: () => sticks(corner, BLACK), job: job({ effects: { indirect_bounces: 1 } }) },
    holds: [["need", "skipped.black_albedo", "==", 0], ["spare", "skipped.black_albedo", ">", 0]] },
  { skip: "ray", name: "below the horizon", about: "a light above the floor, and one below it", saves: ["rays", "bytes"],
    need: { glb: () => sticks([]), job: job({ lights: [bulb] }) }, spare: { glb: () => sticks([]), job: job({ lights: [{ ...bulb, position: [0.5, -4, 1] }] }) },
    holds: [["need", "skipped.light_below_horizon", "==", 0], ["spare", "skipped.light_below_horizon", ">", 0], ["spare", "rays.shadow", "==", 0]] },
];

const member = (frame, path) => path.startsWith("skipped ") ? frame.plan.some((s) => s.what === path.slice(8)) : path.split(".").reduce((o, name) => o?.[name], frame);
const RELATIONS = { ">": (a, b) => a > b, "==": (a, b) => a === b };

// What must be and is not, as sentences.
export function broken(pair, frames) {
  const wrong = pair.holds.map(([which, path, relation, value]) => [which, path, relation, value, member(frames[which], path)])
    .filter(([, , relation, value, is]) => is === undefined || !RELATIONS[relation](is, value))
    .map(([which, path, relation, value, is]) => `${which}: ${path} is ${is}, not ${relation} ${value}`);
  const falls = { rays: (f) => raysOf(f.rays), bytes: (f) => f.bytes_received };
  for (const what of pair.saves)
    if (!(falls[what](frames.spare) < falls[what](frames.need))) wrong.push(`${what} do not fall: ${falls[what](frames.need)} to ${falls[what](frames.spare)}`);
  return wrong;
}

async function frame(farm, o, { glb, job: { camera, ...more } }, name) {
  const file = `${o.out}/skip-${name}.glb`, seen = [];
  writeFileSync(file, glb());
  const document = { ...more, scene: { file, lights: false, camera }, image: { width: o.skipSide, height: o.skipSide } };
  // The first run pays for import and BVH, and tells the plan.
  seen.push(await farm.run(document));
  return { ...await repeated(farm, document, o.repeat), plan: seen[0].plan.skipped };
}

export async function skips(o) {
  // One worker: nobody traces a tile a second time because it comes late, and bytes are the same every time.
  const farm = await Farm.start(o.build, { workers: 1, threads: o.cores });
  try {
    for (const pair of PAIRS) {
      o.say(`skips: ${pair.skip}, ${pair.name}`);
      const frames = { need: await frame(farm, o, pair.need, "need"), spare: await frame(farm, o, pair.spare, "spare") };
      const wrong = broken(pair, frames);
      const cost = ({ rays, bytes_received, cpu_s, wall }) => ({ rays: raysOf(rays), bytes: bytes_received, cpu_s: cpu_s.total - cpu_s.encode, wall_s: wall.total });
      o.put("skips", `${pair.skip} ${pair.name}`, { skip: pair.skip, name: pair.name, about: pair.about, side_px: o.skipSide,
        need: cost(frames.need), spare: cost(frames.spare), holds: wrong.length === 0, wrong, frames });
      if (wrong.length > 0) o.fail(`skip of ${pair.skip}, ${pair.name}: ${wrong.join("; ")}`);
    }
  } finally {
    await farm.stop();
  }
}

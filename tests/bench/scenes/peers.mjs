// The scenes of the peers folder, each a folder of its own: job.json (neither sampling nor filter), reference-a.exr and
// reference-b.exr, and oidn-N.exr, what Intel Open Image Denoise makes of N paths a pixel.
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { ahead } from "./combined.mjs";

const ABOUT = {
  cornell: "the Cornell box, eight bounces", living_room: "a living room under a map through its windows, eight bounces",
  helmet_studio: "FlightHelmet in a studio, four bounces", helmet_park: "FlightHelmet in a park, four bounces",
  spheres_venice: "balls of all metals and roughnesses over Venice, two bounces",
  blocks: "blocks of glTF's default material under a rectangle light, one bounce", blocks_sky: "the same under the sky of Venice, two bounces",
  veach_mis: "Veach's metal plates under four balls of light, four bounces" };

// The document with the files that it names, which lie beside it, as absolute paths.
function documentOf(folder) {
  const job = JSON.parse(readFileSync(join(folder, "job.json"), "utf8"));
  for (const part of [job.scene, job.environment]) if (part?.file) part.file = resolve(folder, part.file);
  return job;
}

function sceneOf(folder, name) {
  const own = join(folder, name), files = readdirSync(own), of = (file) => join(own, file);
  const oidn = files.map((file) => /^oidn-(\d+)\.exr$/.exec(file)).filter(Boolean).map(([file, spp]) => [Number(spp), of(file)]);
  return { name, about: ABOUT[name] ?? name, job: documentOf(own), references: [of("reference-a.exr"), of("reference-b.exr")],
    oidn: Object.fromEntries(oidn) };
}

// The living room a step ahead, focused on its table, as the combined effects have it. Its references are made here.
const throughLens = (scene) => ({ name: `${scene.name}_lens`, about: `${scene.about}, through a lens`,
  job: { ...scene.job, scene: { ...scene.job.scene, camera: ahead }, lens: { aperture_radius: 0.08, focus_distance: 3.1 } } });

// null where there is no such folder.
export function peersScenes(folder) {
  if (!existsSync(folder)) return null;
  const whole = (name) => ["job.json", "reference-a.exr", "reference-b.exr"].every((file) => existsSync(join(folder, name, file)));
  return readdirSync(folder).filter(whole).sort().map((name) => sceneOf(folder, name))
    .flatMap((scene) => scene.name === "living_room" ? [scene, throughLens(scene)] : [scene]);
}

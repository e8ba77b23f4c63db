// scene_files.mjs SCENE SPP FOLDER [SIDE_PX]: a scene of the accuracy bench as files for programs that
// trace without a coordinator: SCENE.glb, and SCENE.json, a job with the sheared filter that takes the
// scene as a blob.
import { writeFileSync } from "node:fs";
import { referenceJob } from "./accuracy/job.mjs";
import { SEED } from "./accuracy/measure.mjs";
import { scenesFolder } from "./folders.mjs";
import { scenes } from "./scenes/scenes.mjs";

const [name, spp, folder, side = 512] = process.argv.slice(2);
const scene = scenes.find((s) => s.name === name);
if (!scene || !folder || !(Number(side) > 0)) {
  console.error("usage: scene_files.mjs SCENE SPP FOLDER [SIDE_PX]");
  process.exit(2);
}
writeFileSync(`${folder}/${name}.glb`, scene.glb(scenesFolder()));
writeFileSync(`${folder}/${name}.json`, JSON.stringify({ ...referenceJob(scene, { side: Number(side) }),
  sampling: { spp: Number(spp), seed: SEED }, filter: { method: "sheared" }, layers: ["beauty", "diffuse_direct"] }));

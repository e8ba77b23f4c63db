// Job documents of the bench. `average` is the light field without a filter: the same samples.

export const METHODS = ["average", "axis_aligned", "sheared"];

const documentOf = (scene, side, file) => ({
  scene: { file, lights: false, camera: scene.camera },
  image: { width: side, height: side },
  lights: scene.lights,
  effects: { indirect_bounces: 0 } });

export const testJob = (scene, side, file, method, spp, seed) => ({ ...documentOf(scene, side, file),
  sampling: { spp, seed }, filter: { method }, layers: ["beauty", "diffuse_direct"] });

// The picture with its anti-aliasing, whose positions change with the seed: the mean of many seeds.
export const beautyJob = (scene, side, file, seed) => ({ ...documentOf(scene, side, file),
  sampling: { spp: 256, seed }, filter: { method: "average" }, layers: ["beauty"] });

// For exr_reference, which takes camera and lights from it; the file comes as a blob.
export const referenceJob = (scene, side) => ({ ...documentOf(scene, side),
  scene: { asset: "0".repeat(64), lights: false, camera: scene.camera } });

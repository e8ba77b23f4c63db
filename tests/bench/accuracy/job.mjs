// Job documents of the bench. `average` is the light field without a filter: the same samples.
import { effectOf } from "./effects.mjs";

const size = (scene, side) => ({ width: Math.round(side * (scene.sides?.[0] ?? 1)), height: Math.round(side * (scene.sides?.[1] ?? 1)) });

const documentOf = (scene, o, file) => ({
  scene: { file, lights: false, ...(scene.camera ? { camera: scene.camera } : {}) },
  image: size(scene, o.side),
  lights: scene.lights,
  ...(scene.lens ? { lens: scene.lens } : {}),
  ...(scene.environment ? { environment: scene.environment(o.shared) } : {}),
  effects: { indirect_bounces: scene.bounces ?? 0 } });

export const megapixels = (scene, side) => size(scene, side).width * size(scene, side).height / 1e6;

export const testJob = (scene, o, file, method, spp, seed) => ({ ...documentOf(scene, o, file),
  sampling: { spp, seed, ...effectOf(scene).sampling?.(method, spp) }, filter: effectOf(scene).filter(method), layers: effectOf(scene).layers });

// Of a method whose bounce rays are turned by mu: beside them as many paths, or samples of lights, as the
// first set has.
export const turnedJob = (scene, o, file, method, mu, seed) => ({ ...testJob(scene, o, file, method, 16, seed),
  filter: effectOf(scene).filter(method, mu) });

// The picture with its anti-aliasing, whose positions change with the seed: the mean of many seeds.
export const beautyJob = (scene, o, file, seed) => ({ ...documentOf(scene, o, file),
  sampling: { spp: 256, seed }, filter: { method: "average" }, layers: ["beauty"] });

// The same by the path tracer alone.
export const pathsJob = (scene, o, file, seed, spp) => ({ ...documentOf(scene, o, file),
  sampling: { spp, seed }, filter: { method: "none" }, layers: ["beauty"] });

// Bounce rays of pixel centres, unfiltered; few paths, as they are not looked at.
export const indirectJob = (scene, o, file, seed, spp) => ({ ...documentOf(scene, o, file),
  sampling: { spp: 4, indirect_spp: spp, seed }, filter: { method: "average" }, layers: ["diffuse_indirect", "albedo", "id"] });

// For exr_away, in the dark: as many lens samples as travel one by one.
export const lensJob = (scene, o) => ({ ...referenceJob(scene, o), environment: undefined, sampling: { spp: 256, seed: 1 }, filter: { lens: "sheared" }, layers: ["beauty"] });

// For exr_reference, which takes camera and lights from it; the file comes as a blob.
export const referenceJob = (scene, o) => ({ ...documentOf(scene, o),
  scene: { asset: "0".repeat(64), lights: false, camera: scene.camera } });

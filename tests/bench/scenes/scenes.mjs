// The scenes of the accuracy bench.
//   name, about, effect: which of accuracy/effects.mjs it shows
//   crop: [x, y, w, h] of a 512 x 512 picture, for people
//   camera (the file's own without one), lights: as in a job document
//   glb(shared): the scene file's bytes, `shared` being the folder of scenes that are not shipped (tests/golden/README.md)
import { combined } from "./combined.mjs";
import { indirect } from "./indirect.mjs";
import { lens } from "./lens.mjs";
import { shadows } from "./shadows.mjs";

export const scenes = [...shadows, ...indirect, ...lens, ...combined];

// All effects through a lens: soft shadows or a sky, several bounces, depth of field. Shapes are those
// of the effects by themselves; the lens is focused in the middle of what lies before it.
import { readFileSync } from "node:fs";
import { join as path } from "node:path";
import { cornell, inside } from "./indirect.mjs";
import { fence, slats } from "./lens.mjs";
import { light } from "./light.mjs";

// The living room's own camera, a step ahead: from where it stands this lens would reach into a wall.
export const ahead = { eye: [4.82, 0.753, -2.24], target: [1.934, 0.976, -1.4495], yfov_deg: 58.7 };

//   bounces, sides, environment: as in indirect.mjs; boundaries: as in lens.mjs; lens: as in a job document
export const combined = [
  { name: "all_living_room", about: "its own materials, a sky through its windows, six bounces, focused on the table",
    bounces: 6, sides: [1, 0.5625], glb: (shared) => readFileSync(path(shared, "glb/living-room/living-room.glb")),
    environment: (shared) => ({ file: path(shared, "glb/living-room/living-room_env.hdr"), intensity: 1, rotation_deg: 0 }),
    camera: ahead, lights: [], lens: { aperture_radius: 0.08, focus_distance: 3.1 }, crop: [200, 150, 128, 128],
    boundaries: [[235, 140, 72, 72], [110, 90, 72, 72]] },
  { name: "all_box", about: "coloured box under an area light, four bounces, focused on its middle", glb: cornell, bounces: 4,
    camera: inside, lights: [light({ center: [0.05, 1.96, 0.1], target: [0.05, 0, 0.1], halfU: 0.28, turn: 0.2, level: [0.5, 0.47, 0.42] })],
    lens: { aperture_radius: 0.09, focus_distance: 3.2 }, crop: [180, 310, 128, 128],
    boundaries: [[190, 380, 72, 72], [95, 395, 72, 72]] },
  { name: "all_fence", about: "a chequered fence out of focus before a room under an area light, two bounces", glb: fence, bounces: 2,
    camera: { eye: [0.1, 1, 4.3], target: [0, 0.9, 0], yfov_deg: 44 },
    lights: [light({ center: [1.3, 3.6, 3.4], target: [0, 0.4, -0.5], halfU: 0.5, turn: 0.3, level: [1, 0.97, 0.88] })],
    lens: { aperture_radius: 0.07, focus_distance: 5, blades: 6 }, crop: [340, 200, 128, 128], boundaries: slats },
].map((scene) => ({ ...scene, effect: "combined" }));

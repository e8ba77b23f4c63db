// Depth of field: through a thin lens, under lights without area, so that samples of the lens differ
// by what they see and hardly by how it is lit. Posts, fence and room are made here (CC0); the
// circuit board and the ball are not shipped.
import { readFileSync } from "node:fs";
import { join as path } from "node:path";
import { glbOf, glbWithout } from "./glb.mjs";
import { box, floor, join, quad, sphere, stick, turned } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const row = (count, make) => join(Array.from({ length: count }, (_, i) => make(i)));
const ONE = [1, 1, 1];

// Posts in a long row from before the camera's focus to far behind it, on a chequered floor.
function posts() {
  const post = (i) => stick([-1.3 + 0.34 * i, 0, 2.6 - 0.95 * i], [-1.3 + 0.34 * i, 1.5, 2.6 - 0.95 * i], 0.09);
  const slab = (i) => turned(box([-0.35, 0, -0.03], [0.35, 1.1, 0.03]), 0.4 + 0.3 * i, [1.4 + 0.45 * i, 0, 1.2 - 2.1 * i]);
  return glbOf([
    { name: "floor", color: ONE, texture: checkerboard(40, 40, [0.22, 0.24, 0.3], [0.62, 0.6, 0.55]), mesh: floor(16) },
    { name: "sky", color: ONE, texture: checkerboard(24, 12, [0.3, 0.4, 0.55], [0.45, 0.55, 0.68]), mesh: quad([-24, -1, -16], [48, 0, 0], [0, 18, 0]) },
    { name: "posts", color: ONE, texture: checkerboard(6, 12, [0.75, 0.2, 0.12], [0.8, 0.78, 0.7]), mesh: row(14, post) },
    { name: "slabs", color: ONE, texture: checkerboard(7, 11, [0.1, 0.35, 0.2], [0.7, 0.75, 0.4]), mesh: row(5, slab) }]);
}

// A fence close to the camera and far out of focus, before a room that is in focus.
export function fence() {
  const slat = (i) => box([-1.6 + 0.31 * i, 0.1, 2.3], [-1.46 + 0.31 * i, 1.75, 2.34]);
  const rail = (y) => box([-1.8, y, 2.34], [1.8, y + 0.12, 2.38]);
  return glbOf([
    { name: "floor", color: ONE, texture: checkerboard(16, 16, [0.3, 0.26, 0.22], [0.68, 0.6, 0.5]), mesh: floor(3) },
    { name: "back", color: ONE, texture: checkerboard(20, 10, [0.25, 0.33, 0.5], [0.6, 0.62, 0.66]), mesh: quad([-3, 0, -1.5], [6, 0, 0], [0, 3, 0]) },
    { name: "left", color: [0.6, 0.25, 0.15], mesh: quad([-2.2, 0, -1.5], [0, 3, 0], [0, 0, 3]) },
    { name: "right", color: [0.2, 0.45, 0.25], mesh: quad([2.2, 0, -1.5], [0, 0, 3], [0, 3, 0]) },
    { name: "ball", color: ONE, texture: checkerboard(24, 12, [0.7, 0.2, 0.15], [0.85, 0.8, 0.7]), mesh: sphere([-0.6, 0.6, -0.4], 0.6) },
    { name: "block", color: [0.75, 0.65, 0.25], mesh: turned(box([-0.4, 0, -0.4], [0.4, 1.2, 0.4]), 0.5, [0.8, 0, -0.6]) },
    { name: "fence", color: ONE, texture: checkerboard(2, 12, [0.15, 0.12, 0.1], [0.85, 0.7, 0.45]),
      mesh: join([row(11, slat), rail(0.45), rail(1.35)]) }]);
}

const sun = (direction, level) => ({ type: "directional", direction, irradiance: [level, 0.96 * level, 0.88 * level] });
const shared = (file, without) => (folder) => glbWithout(readFileSync(path(folder, file)), without);

// Where a slat out of focus crosses a block, the ball, and a rail the floor; of the same camera.
export const slats = [[385, 250, 72, 72], [130, 215, 72, 72], [200, 360, 72, 72]];

//   lens: as in a job document; boundaries: crops of 512 lines where things in and out of focus meet
export const lens = [
  { name: "posts", about: "posts from before the focus to far behind it", glb: posts,
    camera: { eye: [0.2, 1.5, 5.2], target: [0.4, 0.6, 0], yfov_deg: 42 }, lights: [sun([-0.45, -0.75, -0.5], 3.1)],
    lens: { aperture_radius: 0.08, focus_distance: 5.2 }, crop: [60, 230, 128, 128],
    boundaries: [[0, 260, 72, 72], [345, 175, 72, 72]] },
  { name: "fence_room", about: "a chequered fence out of focus before a room in focus", glb: fence,
    camera: { eye: [0.1, 1, 4.3], target: [0, 0.9, 0], yfov_deg: 44 },
    lights: [{ type: "point", position: [1.3, 3.1, 4.6], intensity: [62, 60, 54] }],
    lens: { aperture_radius: 0.07, focus_distance: 5, blades: 6 }, crop: [150, 160, 128, 128], boundaries: slats },
  { name: "dof_bevy", about: "a circuit board close up, some balls of it glowing",
    glb: shared("dof-bevy/DepthOfFieldExample.glb", /^$/),
    camera: { eye: [0, 4.5, 8.25], target: [0, 0, 0], yfov_deg: 42 }, lights: [sun([-0.3, -0.9, -0.35], 1.5)],
    environment: () => ({ radiance: [0.3, 0.33, 0.38] }),
    lens: { aperture_radius: 0.2, focus_distance: 8.3 }, crop: [90, 300, 128, 128], boundaries: [[345, 250, 72, 72], [50, 225, 72, 72]] },
  { name: "dof_luxcore", about: "a metal ball on clay, the lens as its file has it", sides: [1, 0.5625],
    glb: shared("glb/dof-luxcore/dof-luxcore.glb", /point_light/), lights: [sun([-0.6, -0.7, 0.25], 0.12)],
    environment: () => ({ radiance: [0.5, 0.6, 0.75] }),
    lens: { aperture_radius: 0.05, focus_distance: 2.069957, blades: 6 }, crop: [120, 120, 128, 128],
    boundaries: [[185, 110, 72, 72], [150, 140, 72, 72]] },
].map((scene) => ({ ...scene, effect: "lens" }));

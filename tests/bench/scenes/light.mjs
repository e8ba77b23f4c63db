// Lights of the bench's scenes, as job documents have them.
import { length, unit } from "./mesh.mjs";

// A rectangle light at `center` that faces `target`, its sides turned by `turn` about that axis. A
// surface at the target that faces it sends a radiance of about `level` times its albedo.
export function light({ center, target, halfU, halfV = halfU, turn = 0, level = [1, 1, 1], profile = "uniform" }) {
  const way = target.map((x, i) => x - center[i]), n = unit(way), distance = length(way);
  const helper = Math.abs(n[1]) < 0.99 ? [0, 1, 0] : [1, 0, 0];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const p = unit(cross(helper, n)), q = cross(n, p), c = Math.cos(turn), s = Math.sin(turn);
  const area = 4 * halfU * halfV * (profile === "gaussian" ? 0.358 : 1);
  return { type: "rectangle", center, profile,
    half_u: p.map((x, i) => halfU * (c * x + s * q[i])), half_v: p.map((x, i) => halfV * (c * q[i] - s * x)),
    radiance: level.map((l) => l * Math.PI * distance * distance / area) };
}

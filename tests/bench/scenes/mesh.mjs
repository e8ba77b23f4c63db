// Shapes as triangles: {positions, normals, uvs, indices}, flat arrays, Y up. For the bench's own scenes.

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const unit = (a) => a.map((x) => x / length(a));
const along = (p, d, t) => p.map((x, i) => x + d[i] * t);

// Vertices of an nu x nv grid of quads; at(u, v) in [0,1]^2 gives {position, normal}.
function grid(nu, nv, at) {
  const positions = [], normals = [], uvs = [], indices = [];
  for (let j = 0; j <= nv; j++)
    for (let i = 0; i <= nu; i++) {
      const { position, normal } = at(i / nu, j / nv);
      positions.push(...position);
      normals.push(...normal);
      uvs.push(i / nu, j / nv);
    }
  for (let j = 0; j < nv; j++)
    for (let i = 0; i < nu; i++) {
      const a = j * (nu + 1) + i, b = a + nu + 1;
      indices.push(a, b, a + 1, a + 1, b, b + 1);
    }
  return { positions, normals, uvs, indices };
}

// The parallelogram corner + s p + t q, facing p x q.
export function quad(corner, p, q) {
  const normal = unit(cross(p, q));
  return grid(1, 1, (u, v) => ({ position: along(along(corner, p, v), q, u), normal }));
}

// A horizontal square around the origin's axis.
export const floor = (half, y = 0) => quad([-half, y, -half], [0, 0, 2 * half], [2 * half, 0, 0]);

export function join(meshes) {
  const all = { positions: [], normals: [], uvs: [], indices: [] };
  for (const m of meshes) {
    const base = all.positions.length / 3;
    for (const x of m.positions) all.positions.push(x);
    for (const x of m.normals) all.normals.push(x);
    for (const x of m.uvs) all.uvs.push(x);
    for (const i of m.indices) all.indices.push(i + base);
  }
  return all;
}

export function box(from, to) {
  const [x, y, z] = sub(to, from), X = [x, 0, 0], Y = [0, y, 0], Z = [0, 0, z];
  return join([quad(from, X, Z), quad(from, Z, Y), quad(from, Y, X),
    quad(to, [0, 0, -z], [-x, 0, 0]), quad(to, [0, -y, 0], [0, 0, -z]), quad(to, [-x, 0, 0], [0, -y, 0])]);
}

export function sphere(centre, radius, steps = 64) {
  return grid(steps, steps / 2, (u, v) => {
    const a = 2 * Math.PI * u, b = Math.PI * v;
    const normal = [Math.sin(b) * Math.cos(a), Math.cos(b), -Math.sin(b) * Math.sin(a)];
    return { position: along(centre, normal, radius), normal };
  });
}

const TAU = 2 * Math.PI;

// A surface p(u, v) over [0,1]^2 that faces p_v x p_u; normals from its slopes.
function slopes(nu, nv, p) {
  const h = 1e-4, way = (a, b) => sub(b, a);
  return grid(nu, nv, (u, v) => ({ position: p(u, v),
    normal: unit(cross(way(p(u, v - h), p(u, v + h)), way(p(u - h, v), p(u + h, v)))) }));
}

// A ball whose radius differs by up to `height` either way, `bumps` times around and half as often from pole to pole.
export function bumpyBall(centre, radius, height, bumps, steps = 256) {
  return slopes(steps, steps / 2, (u, v) => {
    const a = TAU * u, b = Math.PI * (0.001 + 0.998 * v), r = radius + height * Math.sin(bumps * a) * Math.sin(bumps * b) * Math.sin(b);
    return along(centre, [Math.sin(b) * Math.cos(a), Math.cos(b), -Math.sin(b) * Math.sin(a)], r);
  });
}

// A horizontal disc with round grooves that are `pitch` apart, their slopes up to `slope`.
export function groovedDisc(centre, radius, pitch, slope, steps = 96) {
  const rings = Math.round(12 * radius / pitch);
  return slopes(steps, rings, (u, v) => {
    const r = radius * (0.02 + 0.98 * v), y = slope * pitch / TAU * Math.sin(TAU * r / pitch);
    return along(centre, [r * Math.cos(TAU * u), y, -r * Math.sin(TAU * u)], 1);
  });
}

// A round stick with flat ends.
export function stick(from, to, radius, steps = 24) {
  const axis = unit(sub(to, from));
  const side = unit(cross(axis, Math.abs(axis[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0])), other = cross(axis, side);
  const around = (u) => side.map((x, i) => x * Math.cos(2 * Math.PI * u) + other[i] * Math.sin(2 * Math.PI * u));
  const wall = grid(steps, 1, (u, v) => ({
    position: along(v ? from : to, around(u), radius), normal: around(u) }));
  const end = (centre, normal, turn) => grid(steps, 1, (u, v) => ({
    position: along(centre, around(turn * u), v * radius), normal }));
  return join([wall, end(to, axis, 1), end(from, axis.map((x) => -x), -1)]);
}

// y = height(x, z) over a square; normals from its slopes.
export function hills(half, steps, height) {
  const h = 1e-3;
  return grid(steps, steps, (u, v) => {
    const x = (2 * u - 1) * half, z = (2 * v - 1) * half;
    const dx = (height(x + h, z) - height(x - h, z)) / (2 * h), dz = (height(x, z + h) - height(x, z - h)) / (2 * h);
    return { position: [x, height(x, z), z], normal: unit([-dx, 1, -dz]) };
  });
}

// The mesh turned by `angle` about the vertical through the origin, then moved.
export function turned(mesh, angle, by = [0, 0, 0]) {
  const c = Math.cos(angle), s = Math.sin(angle);
  const turn = (list, move) => list.map((x, i) => {
    const px = list[i - i % 3], pz = list[i - i % 3 + 2];
    return [c * px + s * pz, x, c * pz - s * px][i % 3] + move[i % 3];
  });
  return { ...mesh, positions: turn(mesh.positions, by), normals: turn(mesh.normals, [0, 0, 0]) };
}

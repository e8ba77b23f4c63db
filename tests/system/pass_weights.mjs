// Weights for tests/bench/exr_unet that pass three of the network's nine inputs through: 0 colour, 3 albedo, 6 normal.
//   pass_weights.mjs FIRST OUT.tza
import { writeFileSync } from "node:fs";

const [first, out] = process.argv.slice(2), N = 16;
const LAYERS = { enc_conv0: [9, N], enc_conv1: [N, N], enc_conv2: [N, N], enc_conv3: [N, N], enc_conv4: [N, N], enc_conv5a: [N, N], enc_conv5b: [N, N],
  dec_conv4a: [2 * N, N], dec_conv4b: [N, N], dec_conv3a: [2 * N, N], dec_conv3b: [N, N], dec_conv2a: [2 * N, N], dec_conv2b: [N, N],
  dec_conv1a: [N + 9, N], dec_conv1b: [N, N], dec_conv0: [N, 3] };
const PASSES = { dec_conv1a: N + Number(first), dec_conv1b: 0, dec_conv0: 0 };

function weights(name, inputs, outputs) {
  const values = new Float32Array(outputs * inputs * 9);
  if (name in PASSES) for (let i = 0; i < 3; i++) values[(i * inputs + PASSES[name] + i) * 9 + 4] = 1;
  return values;
}

const tensors = Object.entries(LAYERS).flatMap(([name, [inputs, outputs]]) => [
  { name: `${name}.weight`, sizes: [outputs, inputs, 3, 3], layout: "oihw", values: weights(name, inputs, outputs) },
  { name: `${name}.bias`, sizes: [outputs], layout: "x", values: new Float32Array(outputs) }]);

const u8 = (v) => Buffer.from([v]), u16 = (v) => Buffer.from(Uint16Array.of(v).buffer), u32 = (v) => Buffer.from(Uint32Array.of(v).buffer), u64 = (v) => Buffer.from(BigUint64Array.of(BigInt(v)).buffer);
const HEAD_BYTES = 12, numbers = tensors.map((t) => Buffer.from(t.values.buffer)), end = numbers.reduce((sum, b) => sum + b.length, HEAD_BYTES);
let place = HEAD_BYTES;
const rows = tensors.map((t, i) => {
  const row = [u16(t.name.length), Buffer.from(t.name), u8(t.sizes.length), ...t.sizes.map(u32), Buffer.from(t.layout), Buffer.from("f"), u64(place)];
  place += numbers[i].length;
  return Buffer.concat(row);
});
writeFileSync(out, Buffer.concat([u16(0x41d7), u8(2), u8(0), u64(end), ...numbers, u32(tensors.length), ...rows]));

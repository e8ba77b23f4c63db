// PNG files, and a checkerboard as one: across x down squares, one texel each, of two linear colours in turn.
import { deflateSync } from "node:zlib";

const toSrgb = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));

function crc32(bytes) {
  let c = 0xffffffff;
  for (const byte of bytes) {
    c ^= byte;
    for (let k = 0; k < 8; k++) c = c & 1 ? c >>> 1 ^ 0xedb88320 : c >>> 1;
  }
  return ~c >>> 0;
}

export function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]), out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc32(body), body.length + 4);
  return out;
}

export function checkerboard(across, down, one, other) {
  const row = (y) => [0, ...Array.from({ length: across }, (_, x) => ((x + y) % 2 ? other : one).map(toSrgb)).flat()];
  const header = Buffer.alloc(13);
  header.writeUInt32BE(across, 0);
  header.writeUInt32BE(down, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const texels = Buffer.from(Array.from({ length: down }, (_, y) => row(y)).flat());
  return Buffer.concat([Buffer.from("89504e470d0a1a0a", "hex"), chunk("IHDR", header),
    chunk("IDAT", deflateSync(texels)), chunk("IEND", Buffer.alloc(0))]);
}

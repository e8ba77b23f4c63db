// PNG files of 8-bit RGB: pictures, and checkerboards.
import { deflateSync } from "node:zlib";

export const toSrgb = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));

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

function pngOf(width, height, rows) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from("89504e470d0a1a0a", "hex"), chunk("IHDR", header), chunk("IDAT", rows), chunk("IEND", Buffer.alloc(0))]);
}

// Makes across x down squares, one texel each, of two linear colours in turn.
export function checkerboard(across, down, one, other) {
  const row = (y) => [0, ...Array.from({ length: across }, (_, x) => ((x + y) % 2 ? other : one).map(toSrgb)).flat()];
  return pngOf(across, down, deflateSync(Buffer.from(Array.from({ length: down }, (_, y) => row(y)).flat())));
}

// Encodes `rgb`, which holds rows from the top, as differences from the row above.
export function encodePicture(rgb, width, height) {
  const stride = 3 * width, lines = Buffer.alloc((stride + 1) * height, 2);
  for (let y = 0; y < height; y++)
    for (let i = 0; i < stride; i++) lines[y * (stride + 1) + 1 + i] = rgb[y * stride + i] - (y > 0 ? rgb[(y - 1) * stride + i] : 0);
  return pngOf(width, height, deflateSync(lines, { level: 9 }));
}

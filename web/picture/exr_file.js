// Reads OpenEXR files of scan lines, one part, uncompressed or deflated (ZIPS, ZIP): what Shearwater
// and most renderers write. Errors say what else a file is.

import { halfTable } from "./half.js";

const LINES = { 0: 1, 2: 1, 3: 16 }; // by compression: none, ZIPS, ZIP
const NAMES = ["none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"];
const BYTES = [4, 2, 4]; // by pixel type: uint, half, float
const MOST_PIXELS = 1 << 27;
const MOST_NUMBERS = 1 << 29; // of all channels together, which become floats: 2 GiB

// {width, height, channels: Map of name to Float32Array, half: a Set of the names that were halves}.
export async function readExr(buffer) {
  try {
    return await read(buffer);
  } catch (error) {
    if (error instanceof RangeError || error instanceof TypeError) throw new Error("The EXR file is cut off or broken.");
    throw error;
  }
}

async function read(buffer) {
  const halves = halfTable();
  const header = readHeader(new DataView(buffer));
  const { width, height, channels, compression, top, offsets } = header;
  const out = new Map(channels.map(({ name }) => [name, new Float32Array(width * height)]));
  const view = new DataView(buffer), lines = LINES[compression];
  const stride = channels.reduce((sum, { type }) => sum + BYTES[type] * width, 0);
  for (let i = 0; i < Math.ceil(height / lines); i++) {
    const at = Number(view.getBigUint64(offsets + 8 * i, true));
    const y = view.getInt32(at, true) - top, rows = Math.min(lines, height - y), size = view.getInt32(at + 4, true);
    if (y < 0 || y >= height || size < 0 || at + 8 + size > buffer.byteLength) throw new Error("The EXR file is cut off.");
    let bytes = new Uint8Array(buffer, at + 8, size);
    if (compression !== 0 && size < rows * stride) bytes = restore(await inflate(bytes, rows * stride));
    if (bytes.byteLength !== rows * stride) throw new Error("The EXR file has a block of a wrong size.");
    readRows(bytes, y, rows, header, out, halves);
  }
  return { width, height, channels: out, half: new Set(channels.filter(({ type }) => type === 1).map(({ name }) => name)) };
}

function readHeader(view) {
  if (view.byteLength < 8 || view.getUint32(0, true) !== 20000630) throw new Error("This is not an EXR file.");
  if (view.getUint32(4, true) & 0x1a00) throw new Error("Tiled, multi-part and deep EXR files are not supported.");
  let at = 8;
  const text = () => {
    let s = "";
    for (let c; (c = view.getUint8(at++)) !== 0;) s += String.fromCharCode(c);
    return s;
  };
  const found = {};
  for (let name; (name = text()) !== "";) {
    text();
    const size = view.getInt32(at, true);
    found[name] = at += 4;
    if (size < 0 || at + size > view.byteLength) throw new Error("The EXR file's header is broken.");
    at += size;
  }
  for (const name of ["channels", "compression", "dataWindow"])
    if (found[name] === undefined) throw new Error(`The EXR file has no ${name}.`);
  const offsets = at, [left, top, right, bottom] = [0, 4, 8, 12].map((i) => view.getInt32(found.dataWindow + i, true));
  const width = right - left + 1, height = bottom - top + 1, compression = view.getUint8(found.compression);
  if (width < 1 || height < 1 || width * height > MOST_PIXELS) throw new Error("The EXR file's size is out of range.");
  if (!LINES[compression]) {
    throw new Error(`This EXR file is compressed with ${NAMES[compression] ?? `method ${compression}`}, which this page does not read: `
      + "choose its job instead, or save it with ZIP (exr_compression).");
  }
  const channels = [];
  at = found.channels;
  for (let name; (name = text()) !== "";) {
    const type = view.getInt32(at, true), sampling = view.getInt32(at + 8, true) * view.getInt32(at + 12, true);
    if (!BYTES[type] || sampling !== 1) throw new Error(`The EXR file's channel ${name} is not supported.`);
    channels.push({ name, type });
    at += 16;
  }
  if (width * height * channels.length > MOST_NUMBERS)
    throw new Error(`The EXR file has ${channels.length} channels of ${width} x ${height} pixels, which is too much for this page.`);
  if (offsets + 8 * Math.ceil(height / LINES[compression]) > view.byteLength) throw new Error("The EXR file is cut off.");
  return { width, height, channels, compression, top, offsets };
}

// At most that many bytes: a few may say that they are millions.
async function inflate(bytes, most) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  const out = new Uint8Array(most);
  for (let at = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return out.subarray(0, at);
    if (at + value.byteLength > most) {
      await reader.cancel();
      throw new Error("The EXR file has a block that is larger than its lines.");
    }
    out.set(value, at);
    at += value.byteLength;
  }
}

// Undoes the differences between bytes and their order: first halves of pairs, then second ones.
function restore(bytes) {
  for (let i = 1; i < bytes.length; i++) bytes[i] = bytes[i - 1] + bytes[i] - 128;
  const out = new Uint8Array(bytes.length), half = (bytes.length + 1) >> 1;
  for (let i = 0; i < bytes.length; i++) out[i] = bytes[i & 1 ? half + (i >> 1) : i >> 1];
  return out;
}

function readRows(bytes, y, rows, { width, channels }, out, halves) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  for (let row = y; row < y + rows; row++)
    for (const { name, type } of channels) {
      const values = out.get(name);
      for (let i = row * width; i < (row + 1) * width; i++, at += BYTES[type])
        values[i] = type === 1 ? halves[view.getUint16(at, true)] : type === 2 ? view.getFloat32(at, true) : view.getUint32(at, true);
    }
}

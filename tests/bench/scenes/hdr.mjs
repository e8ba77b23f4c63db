// Radiance pictures: environment maps that the bench makes itself.

// Three numbers with the exponent of the largest.
function encode(rgb) {
  const most = Math.max(...rgb);
  if (!(most > 1e-32)) return [0, 0, 0, 0];
  const exponent = Math.floor(Math.log2(most)) + 1;
  return [...rgb.map((v) => Math.min(255, Math.floor(v * 2 ** (8 - exponent)))), exponent + 128];
}

// at([x, y, z]) is the radiance [r, g, b] from that direction, of unit length, Y up; the rows go from the zenith down. The
// first column looks along +x, so that a job must turn the map by 180 degrees for directions to be those of its scene.
export function radiance(width, height, at) {
  const texels = [];
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const a = 2 * Math.PI * (x + 0.5) / width, b = Math.PI * (y + 0.5) / height;
      texels.push(...encode(at([Math.sin(b) * Math.cos(a), Math.cos(b), Math.sin(b) * Math.sin(a)])));
    }
  return Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), Buffer.from(texels)]);
}

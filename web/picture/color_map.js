// Colours for numbers: a ramp for magnitudes and one for signs, made in OKLab (Ottosson 2020), so
// that equal steps of a value look like equal steps, also without seeing colours.

export const STEPS = 256;

// OKLab lightness, chroma, hue in degrees to sRGB bytes.
function bytes(lightness, chroma, hue) {
  const a = chroma * Math.cos(hue * Math.PI / 180), b = chroma * Math.sin(hue * Math.PI / 180);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s].map((linear) => {
    const v = Math.min(1, Math.max(0, linear));
    return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  });
}

function ramp(color) {
  const out = new Uint8Array(STEPS * 4);
  for (let i = 0; i < STEPS; i++) out.set([...color(i / (STEPS - 1)), 255], i * 4);
  return out;
}

// From a dark violet over teal to a light yellow: lightness grows evenly with the value.
export const magnitudes = () =>
  ramp((t) => bytes(0.2 + 0.75 * t, 0.13 * Math.sin(Math.PI * (0.15 + 0.75 * t)) + 0.02, 300 - 200 * t));

// Blue below zero, dark at it, orange above.
export const signs = () => ramp((t) => {
  const size = Math.abs(2 * t - 1);
  return bytes(0.16 + 0.68 * size, 0.16 * Math.min(1, 1.3 * size), t < 0.5 ? 245 : 55);
});

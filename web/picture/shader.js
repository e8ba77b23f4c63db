// The shader that shows a layer: where a pixel of the screen lies in the picture, what is there, and
// which colour that is. Numbers that the controls change are uniforms; kinds of pictures are programs of
// their own, since what draws without a GPU runs through all that a program has.

import { viewedText } from "./view_transform.js";

export const VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

export const SHOWN_AS = { picture: 0, colour: 1, sign: 2, vector: 3 };
export const BEHIND = { black: 0, checkerboard: 1, white: 2, alpha: 3 };
export const COMPARE = { off: 0, wipe: 1, other: 2, difference: 3, onion: 4 };

// compare and shownAs as above; curve as in view_transform.js; alpha: a layer has some; mean: pixels of the
// picture are smaller than the canvas's.
export const fragment = ({ compare, shownAs, curve, alpha, mean }) => `#version 300 es
#define COMPARE ${COMPARE[compare]}
#define SHOWN_AS ${SHOWN_AS[shownAs]}
#define ALPHA ${Number(alpha)}
#define MEAN ${Number(mean)}
#define LINEAR ${Number(curve === "linear")}
precision highp float;
precision highp int;
uniform sampler2D first, other, ramps, firstAlpha, otherAlpha; // without alpha one texel of 1
uniform ivec2 firstSize, otherSize;
uniform vec2 firstTexels, otherTexels; // of the texture a pixel of the picture: below 1 of a coarse one
uniform float canvasHeight, zoom;   // zoom: pixels of the canvas a pixel of the picture
uniform vec2 origin;                // the picture's point in the canvas's upper left corner
uniform int behind;
uniform vec3 line;                  // of the wipe: x * line.x + y * line.y > line.z is the other's
uniform float exposure, gamma, low, high;
uniform bool dither, clipMarks, logarithmic;
out vec4 color;

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
const vec3 SURROUND = vec3(0.043, 0.051, 0.059);

bool isFinite(vec3 v) { return !any(isnan(v)) && !any(isinf(v)); }

vec3 one(sampler2D layer, vec2 at, vec2 texels) {
  return texelFetch(layer, clamp(ivec2(floor((floor(at) + 0.5) * texels)), ivec2(0), textureSize(layer, 0) - 1), 0).rgb;
}

// The mean of the picture over one pixel of the canvas. A value that is not finite wins: zoomed out,
// it must not vanish.
vec3 fetch(sampler2D layer, vec2 at, vec2 texels) {
#if MEAN == 0
  return one(layer, at, texels);
#else
  int taps = clamp(int(ceil(1.0 / zoom - 0.01)), 1, 6);
  vec3 sum = vec3(0.0);
  for (int j = 0; j < taps; j++)
    for (int i = 0; i < taps; i++) {
      vec2 offset = ((vec2(i, j) + 0.5) / float(taps) - 0.5) / zoom;
      vec3 v = one(layer, at + (taps > 1 ? offset : vec2(0.0)), texels);
      if (!isFinite(v)) return v;
      sum += v;
    }
  return sum / float(taps * taps);
#endif
}

// The same of how much of a pixel a surface covers.
float fetchAlpha(sampler2D alpha, vec2 at, ivec2 size) {
  if (textureSize(alpha, 0) != size) return 1.0;
  return clamp(fetch(alpha, at, vec2(1.0)).r, 0.0, 1.0);
}

bool inside(ivec2 size, vec2 at) { return all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(size))); }

vec3 encode(vec3 linear) {
  vec3 v = clamp(linear, 0.0, 1.0);
  vec3 srgb = mix(1.055 * pow(max(v, 1e-8), vec3(1.0 / 2.4)) - 0.055, 12.92 * v, lessThanEqual(v, vec3(0.0031308)));
  if (gamma == 1.0) return srgb; // powers are what this costs without a GPU
  return pow(max(srgb, 0.0), vec3(1.0 / gamma));
}

${viewedText(curve)}

// A number of the screen's pixel, the same at every drawing, triangular in (-1, 1).
float noise(uvec2 p, uint channel) {
  uint h = p.x * 1664525u + p.y * 22695477u + channel * 374761393u;
  h = (h ^ h >> 15) * 2246822519u;
  h = (h ^ h >> 13) * 3266489917u;
  h ^= h >> 16;
  return float(h & 0xffffu) / 65535.0 - float(h >> 16) / 65535.0;
}

vec3 ramp(float t, int row) { return texelFetch(ramps, ivec2(int(clamp(t, 0.0, 1.0) * 255.0 + 0.5), row), 0).rgb; }

// Colours are those of what covers the pixel, alpha taken in: the ground shows through the rest.
vec3 ground(vec2 screen) {
  if (behind == 0) return vec3(0.0);
  bool light = mod(floor(screen.x / 8.0) + floor(screen.y / 8.0), 2.0) < 1.0;
  return vec3(behind == 2 ? 1.0 : light ? 0.32 : 0.13);
}

vec3 shown(vec3 v, float alpha, vec2 screen) {
#if SHOWN_AS == 1
  float scalar = dot(v, LUMINANCE);
  if (logarithmic) return ramp(log(max(scalar, low) / low) / log(high / low), 0);
  return ramp((scalar - low) / max(high - low, 1e-30), 0);
#elif SHOWN_AS == 2
  return ramp(0.5 + 0.5 * dot(v, LUMINANCE) / max(high, 1e-30), 1);
#elif SHOWN_AS == 3
  return clamp(v * 0.5 + 0.5, 0.0, 1.0);
#else
  if (behind == 3) return vec3(alpha);
  v *= exp2(exposure);
  bool stripe = mod(screen.x + screen.y, 8.0) < 4.0;
#if LINEAR == 1
  bool clipped = any(greaterThan(v, vec3(1.0)));
  v = viewed(v);
#else
  v = viewed(v);
  bool clipped = any(greaterThan(v, vec3(0.9955))); // the byte 255
#endif
  if (clipMarks && clipped && stripe) return vec3(0.9, 0.1, 0.1);
#if ALPHA == 1
  v += (1.0 - alpha) * ground(screen);
#endif
  return encode(v);
#endif
}

vec3 at(vec2 screen, vec2 p) {
#if COMPARE == 3
  if (!inside(firstSize, p) || !inside(otherSize, p)) return SURROUND;
  vec3 v = fetch(first, p, firstTexels) - fetch(other, p, otherTexels);
  if (!isFinite(v)) return vec3(1.0, 0.0, 1.0);
#if SHOWN_AS == 0
  v = abs(v);
#endif
  return shown(v, 1.0, screen);
#else
#if COMPARE == 1
  bool isOther = dot(screen, line.xy) > line.z;
#else
  const bool isOther = COMPARE == 2;
#endif
  if (!inside(isOther ? otherSize : firstSize, p)) return SURROUND;
  vec3 v;
  if (isOther) v = fetch(other, p, otherTexels);
  else v = fetch(first, p, firstTexels);
  float alpha = 1.0;
#if ALPHA == 1
  alpha = isOther ? fetchAlpha(otherAlpha, p, otherSize) : fetchAlpha(firstAlpha, p, firstSize);
#endif
#if COMPARE == 4
  if (inside(otherSize, p)) {
    v = 0.5 * (v + fetch(other, p, otherTexels));
    alpha = 0.5 * (alpha + fetchAlpha(otherAlpha, p, otherSize));
  }
#endif
  bool check = mod(floor(screen.x / 3.0) + floor(screen.y / 3.0), 2.0) < 1.0;
  if (any(isnan(v))) return check ? vec3(1.0, 0.0, 1.0) : vec3(0.0);
  if (any(isinf(v))) return check ? vec3(0.0, 1.0, 1.0) : vec3(0.0);
  return shown(v, alpha, screen);
#endif
}

void main() {
  vec2 screen = vec2(gl_FragCoord.x, canvasHeight - gl_FragCoord.y);
  vec3 c = at(screen, origin + screen / zoom);
#if COMPARE == 1
  if (abs(dot(screen, line.xy) - line.z) < 1.0) c = vec3(1.0);
#endif
#if SHOWN_AS == 0
  if (dither)
    c += vec3(noise(uvec2(screen), 0u), noise(uvec2(screen), 1u), noise(uvec2(screen), 2u)) / 255.0;
#endif
  color = vec4(c, 1.0);
}`;

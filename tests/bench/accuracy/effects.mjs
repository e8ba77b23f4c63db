// What the bench looks at, effect by effect: the methods compared, the layer and the pixels that are
// judged, the samples at which figures are quoted.
//   methods: the first is the plain average of the same samples
//   against: methods whose curves give equal-error factors
//   at: the count of samples per pixel that bounds speak of; stage: the filter's, in cpu_s
//   where: layer,above,below of the reference; times: the reference's layer that weighs the error
//   relative: errors are divided by the reference's mean
//   turned: methods whose rays hang on the scene, by filter.mu; their count of samples is measured
//   parts: more pixels to judge by themselves, as where has them
//   costs: {method, isa}: what a method costs with that instruction set, too, of which a bound speaks

const shadows = {
  name: "shadows", title: "soft shadows", layer: "diffuse_direct", where: "visibility,0.02,0.98", region: "penumbra",
  samples: "samples a light and pixel", error: "RMSE, penumbra",
  methods: ["average", "axis_aligned", "sheared"], against: ["average", "axis_aligned"], at: 9, stage: "shadow",
  filter: (method) => ({ method }), layers: ["beauty", "diffuse_direct"],
  says: "of the light that a white surface would send at pixel centres (layer diffuse_direct) where the reference's " +
    "visibility lies in (0.02, 0.98)" };

const indirect = {
  name: "indirect", title: "indirect light", layer: "diffuse_indirect", where: "id,0.5,1e9", times: "albedo", region: "surfaces",
  relative: true, samples: "bounce rays a pixel", error: "RMSE over mean indirect light",
  methods: ["average", "constant", "linear", "blend", "auto", "adaptive", "sheared"], against: ["average"], at: 16, stage: "indirect",
  turned: ["adaptive"],
  filter: (method, mu) => ({ indirect: method, ...(mu ? { mu } : {}) }), layers: ["beauty", "diffuse_indirect", "albedo", "id"],
  says: "of indirect light at pixel centres times the reference's albedo, over all surfaces, as parts of its mean there; the " +
    "variance of the reference itself, known from its two halves, is taken off" };

// extra: the sheared filter with second sets, as many paths again in the mean as the first has, on the
// pixels that need them most. Its samples are counted as those of the first set.
// paths: the path tracer without strata for a filter, whose points are spread more evenly. Where all
// that the lens shows of a pixel lies at about one depth, a filter has most to gain.
const lens = {
  name: "lens", title: "depth of field", layer: "beauty", region: "all pixels", parts: { away: "visibility,0.5,1.5" },
  relative: true, samples: "lens samples a pixel", error: "RMSE over mean radiance",
  methods: ["average", "paths", "axis_aligned", "sheared", "extra"], against: ["average", "paths", "axis_aligned"], at: 9, stage: "lens",
  costs: { method: "sheared", isa: "avx2" },
  filter: (method) => method === "paths" ? { method: "none" } : { lens: method === "extra" ? "sheared" : method }, layers: ["beauty"],
  sampling: (method, spp) => method === "extra" ? { lens_extra: Math.min(spp, 36) } : {},
  says: "of the picture over all pixels, as parts of its mean; \"away\" are those whose slopes over 256 lens samples lie within " +
    "one pixel; the variance of the reference itself, known from its two halves, is taken off" };

// Soft shadows and indirect light beside the lens, each with its filter (auto) or none of them (average).
// Where all that the lens shows of a pixel lies at about one depth, light is what varies; elsewhere, at
// silhouettes out of focus, filters may leave halos.
const combined = {
  name: "combined", title: "all effects through a lens", layer: "beauty", region: "all pixels",
  parts: { away: "visibility,0.5,1.5", edges: "visibility,-0.5,0.5" },
  relative: true, samples: "lens samples a pixel", error: "RMSE over mean radiance",
  methods: ["average", "paths", "auto"], against: ["average", "paths"], at: 9, stage: "lens_relight",
  filter: (method) => ({ method: method === "paths" ? "none" : method }), layers: ["beauty"],
  says: "of the picture over all pixels, as parts of its mean; \"edges\" are those whose slopes over 256 lens samples do not lie " +
    "within one pixel; the variance of the reference itself, known from its two halves, is taken off" };

export const effects = { shadows, indirect, lens, combined };
export const effectOf = (scene) => effects[scene.effect];

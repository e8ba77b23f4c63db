// The members of a job document that the form asks for: their names, limits and defaults are those of
// proto/openapi.yaml (tests/browser/submit.test.mjs holds them to it).
//
// A field: {at: its place below its group's, label, kind, ...}. Kinds: integer and number ({min, max,
// above: exclusive, otherwise: the default}), choice ({of, otherwise}), flag, vector, color, several
// ({of, otherwise}), words (a list, parted by commas), word and text ({longest}), digest, variant ({of: [{label, value, is, fields}]}: another shape of the same
// member), lights. A member that is left empty is left out: its default holds.

const COORDINATE = 1e15, RADIANCE = 1e12;
const vector = (at, label) => ({ at, label, kind: "vector", min: -COORDINATE, max: COORDINATE });
const color = (at, label) => ({ at, label, kind: "color", min: 0, max: RADIANCE });
const isObject = (value) => value !== null && typeof value === "object";

export const LAYERS = ["beauty", "direct", "indirect", "albedo", "normal", "depth", "samples", "visibility", "slope_min",
  "slope_max", "emission", "id", "filter_width", "error", "occlusion", "diffuse_direct", "diffuse_indirect",
  "motion.backward", "motion.forward", "composite", "catcher", "overlay", "CryptoObject", "CryptoMaterial",
  "backplate"];

export const LIGHTS = {
  rectangle: {
    value: { type: "rectangle", center: [0, 2, 0], half_u: [0.5, 0, 0], half_v: [0, 0, 0.5], radiance: [10, 10, 10] },
    fields: [vector("/center", "Centre"), vector("/half_u", "Half side u"), vector("/half_v", "Half side v"),
      color("/radiance", "Radiance"),
      { at: "/profile", label: "Profile", kind: "choice", of: ["uniform", "gaussian"], otherwise: "uniform" }],
    hint: "The light emits to the side of u × v.",
  },
  point: {
    value: { type: "point", position: [0, 2, 0], intensity: [10, 10, 10] },
    fields: [vector("/position", "Position"), color("/intensity", "Intensity")],
  },
  spot: {
    value: { type: "spot", position: [0, 2, 0], direction: [0, -1, 0], intensity: [10, 10, 10], outer_deg: 45 },
    fields: [vector("/position", "Position"), vector("/direction", "Direction"), color("/intensity", "Intensity"),
      { at: "/inner_deg", label: "Inner angle", unit: "°", kind: "number", min: 0, max: 90, otherwise: 0 },
      { at: "/outer_deg", label: "Outer angle", unit: "°", kind: "number", min: 0, max: 90, otherwise: 45 }],
  },
  directional: {
    value: { type: "directional", direction: [0, -1, 0], irradiance: [3, 3, 3] },
    fields: [vector("/direction", "Direction"), color("/irradiance", "Irradiance")],
    hint: "The light travels along the direction.",
  },
};

// What a camera of its own starts from, when no plan has told of a better one.
export const LOOK_AT = { eye: [0, 1, 5], target: [0, 1, 0], yfov_deg: 45 };
export const LOOK_AT_FIELDS = [vector("/eye", "Eye"), vector("/target", "Target"),
  { ...vector("/up", "Up"), otherwise: [0, 1, 0] },
  { at: "/yfov_deg", label: "Vertical field of view", unit: "°", kind: "number", above: 0, max: 179, otherwise: 45 }];

export const GROUPS = [
  { title: "Name", fields: [
    { at: "/name", label: "Name", kind: "word", longest: 200, otherwise: null },
    { at: "/labels", label: "Labels", kind: "words", otherwise: [], hint: "parted by commas; jobs are found by them" },
    { at: "/comment", label: "Comment", kind: "text", longest: 4000, otherwise: null },
    { at: "/webhook", label: "Tell of its end", kind: "variant", of: [
      { label: "nobody", value: null, is: (value) => !isObject(value), fields: [] },
      { label: "an address", value: { url: "https://" }, is: isObject,
        fields: [{ at: "/url", label: "Address (URL)", kind: "word", longest: 1024, hint: "its host must be one that the operator allows" }] }] }] },
  { title: "Camera", fields: [{ at: "/scene/camera", label: "Camera", kind: "camera" }] },
  { title: "Materials", fields: [
    { at: "/scene/variant", label: "Variant", kind: "word", longest: 255, otherwise: null, hint: "a name in the scene; none: its own materials" }] },
  { title: "Image", fields: [
    { at: "/image/width", label: "Width", unit: "px", kind: "integer", min: 1, max: 16384, otherwise: 720 },
    { at: "/image/height", label: "Height", unit: "px", kind: "integer", min: 1, max: 16384, otherwise: 720 },
    { at: "/image/pixel_type", label: "EXR pixel type", kind: "choice", of: ["float", "half"], otherwise: "float" },
    { at: "/image/pixel_filter", label: "Pixel filter", kind: "choice", of: ["box", "tent"], otherwise: "box" },
    { at: "/image/exr_compression", label: "EXR compression", kind: "choice", of: ["none", "zips", "zip", "piz", "dwaa"], otherwise: "zip" },
    { at: "/image/view", label: "View", kind: "choice", of: ["linear", "filmic", "agx"], otherwise: "agx" },
    { at: "/image/exposure", label: "Exposure", unit: "stops", kind: "number", min: -32, max: 32, otherwise: 0 },
    { at: "/image/png_bits", label: "PNG bits", kind: "choice", of: [8, 16], otherwise: 8 },
    { at: "/image/png_alpha", label: "PNG is transparent where no surface is", kind: "flag", otherwise: false },
    { at: "/scene/default_camera", label: "Camera where the scene has none", kind: "choice", of: ["front", "three_quarter"], otherwise: "front" }] },
  { title: "Lights", fields: [
    { at: "/scene/lights", label: "Use the scene's own lights", kind: "flag", otherwise: true },
    { at: "/scene/default_light", label: "Studio light where nothing else lights", kind: "flag", otherwise: true },
    { at: "/lights", label: "Lights of the job", kind: "lights", most: 64 }] },
  { title: "Environment", fields: [{ at: "/environment", label: "Environment", kind: "variant", of: [
    { label: "none", value: null, is: (value) => !isObject(value), fields: [] },
    { label: "a map", value: { asset: "" }, is: (value) => isObject(value) && !("radiance" in value), fields: [
      { at: "/asset", label: "Map", kind: "digest", accept: ".hdr,.exr" },
      { at: "/intensity", label: "Intensity", kind: "number", min: 0, max: RADIANCE, otherwise: 1 },
      { at: "/rotation_deg", label: "Rotation", unit: "°", kind: "number", min: -360, max: 360, otherwise: 0 }] },
    { label: "constant", value: { radiance: [1, 1, 1] }, is: (value) => isObject(value) && "radiance" in value,
      fields: [color("/radiance", "Radiance")] }] }] },
  { title: "Photograph", fields: [
    { at: "/backplate", label: "Photograph behind the objects", kind: "variant", of: [
      { label: "none", value: null, is: (value) => !isObject(value), fields: [] },
      { label: "a photograph", value: { asset: "" }, is: isObject, fields: [
        { at: "/asset", label: "Photograph", kind: "digest", accept: ".jpg,.jpeg,.png,.webp,.exr,.hdr" },
        { at: "/fit", label: "Fit", kind: "choice", of: ["exact", "cover", "stretch"], otherwise: "exact" },
        { at: "/color_space", label: "Colour space", kind: "choice", of: ["srgb", "linear"], otherwise: "srgb" }] }] },
    { at: "/rgbd", label: "Colour and depth around the objects", kind: "variant", of: [
      { label: "none", value: null, is: (value) => !isObject(value), fields: [] },
      { label: "a sequence", value: { document: "" }, is: isObject, fields: [
        { at: "/document", label: "Document", kind: "word", longest: 511, hint: "its name among the scene's files" },
        { at: "/surfaces", label: "Surfaces", kind: "choice", of: ["screen", "fused"], otherwise: "screen", hint: "what each frame saw, or one model of all frames" },
        { at: "/light", label: "Light", kind: "choice", of: ["auto", "estimate", "studio"], otherwise: "auto", hint: "what frames tell of it where nothing else lights the scene, always, or never" },
        { at: "/fit", label: "Fit", kind: "choice", of: ["exact", "stretch"], otherwise: "exact" },
        { at: "/color_space", label: "Colour space", kind: "choice", of: ["srgb", "linear"], otherwise: "srgb" }] }] },
    { at: "/catchers", label: "Catchers", kind: "words", grounds: true, otherwise: [], hint: "nodes or materials that stand for what it shows, parted by commas; \"ground 0\" is a floor at that height" },
    { at: "/holdouts", label: "Holdouts", kind: "words", otherwise: [], hint: "those that hide objects behind them" },
    { at: "/composite/mode", label: "Shadows and light", kind: "choice", of: ["multiplicative", "additive"], otherwise: "multiplicative" }] },
  { title: "Shutter", fields: [{ at: "/camera/shutter", label: "Shutter", kind: "variant", of: [
    { label: "a moment", value: null, is: (value) => !isObject(value), fields: [] },
    { label: "open", value: { fraction: 0.5 }, is: isObject, fields: [
      { at: "/fraction", label: "Share of a frame", kind: "number", min: 0, max: 1 },
      { at: "/centre", label: "Half way, in frames after its time", kind: "number", min: -1, max: 1, otherwise: 0 }] }] }] },
  { title: "Lens", fields: [{ at: "/lens", label: "Lens", kind: "variant", of: [
    { label: "pinhole", value: null, is: (value) => !isObject(value), fields: [] },
    { label: "thin lens", value: { aperture_radius: 0.05, focus_distance: 5 }, is: isObject, fields: [
      { at: "/aperture_radius", label: "Aperture radius", kind: "number", min: 0, max: COORDINATE },
      { at: "/focus_distance", label: "Focus distance", kind: "number", min: 0, max: COORDINATE },
      { at: "/blades", label: "Blades", kind: "integer", min: 0, max: 32, otherwise: 0 },
      { at: "/blade_rotation_deg", label: "Blade rotation", unit: "°", kind: "number", min: -360, max: 360, otherwise: 0 }] }] }] },
  { title: "Effects", fields: [
    { at: "/effects/indirect_bounces", label: "Indirect bounces", kind: "integer", min: 0, max: 64, otherwise: 1 },
    { at: "/effects/ambient_occlusion", label: "Ambient occlusion", kind: "variant", of: [
      { label: "none", value: false, is: (value) => !isObject(value), fields: [] },
      { label: "within a distance", value: { distance: 1 }, is: isObject,
        fields: [{ at: "/distance", label: "Distance", kind: "number", above: 0, max: COORDINATE }] }] }] },
  { title: "Sampling", fields: [
    { at: "/sampling/spp", label: "Samples per pixel", kind: "integer", min: 1, max: 65536, otherwise: 9 },
    { at: "/sampling/seed", label: "Seed", kind: "integer", min: 0, max: 9007199254740992, otherwise: 1 },
    { at: "/sampling/target_error", label: "Target error (0: none)", kind: "number", min: 0, max: 1000, otherwise: 0 },
    { at: "/sampling/max_spp", label: "Most samples for the target", kind: "integer", min: 0, max: 65536, otherwise: 0 }],
    more: [
    { at: "/sampling/light_spp", label: "Samples per light (0: as above)", kind: "integer", min: 0, max: 65536, otherwise: 0 },
    { at: "/sampling/indirect_spp", label: "Bounce rays (0: as above)", kind: "integer", min: 0, max: 65536, otherwise: 0 },
    { at: "/sampling/field_scale", label: "Pixels with bounce rays, an axis", kind: "choice", of: ["auto", 1, 0.5], otherwise: "auto" },
    { at: "/sampling/lens_spp", label: "Lens samples (0: as above)", kind: "integer", min: 0, max: 65536, otherwise: 0 },
    { at: "/sampling/lens_extra", label: "Extra lens samples", kind: "integer", min: 0, max: 36, otherwise: 0 },
    { at: "/sampling/tile_px", label: "Tile size", unit: "px", kind: "integer", min: 8, max: 256, otherwise: 64 }] },
  { title: "Filter", fields: [
    { at: "/filter/method", label: "Method (soft shadows)", kind: "choice", of: ["auto", "sheared", "axis_aligned", "average", "none"], otherwise: "auto" },
    { at: "/filter/mu", label: "Width factor (mu)", kind: "number", above: 0, max: 100, otherwise: 1 }],
    more: [
    { at: "/filter/environment", label: "Environment", kind: "choice", of: ["auto", "average", "axis_aligned"], otherwise: "auto" },
    { at: "/filter/indirect", label: "Indirect light", kind: "choice", otherwise: "auto",
      of: ["auto", "average", "constant", "linear", "blend", "adaptive", "sheared"] },
    { at: "/filter/glossy", label: "Glossy reflections", kind: "choice", otherwise: "auto",
      of: ["auto", "average", "virtual_hit", "bandlimit", "sg", "sg_mixture", "asg"] },
    { at: "/filter/lens", label: "Depth of field", kind: "choice", of: ["auto", "average", "axis_aligned", "sheared"], otherwise: "auto" },
    { at: "/filter/residual", label: "Light along paths", kind: "choice", of: ["auto", "none", "halves", "oidn"], otherwise: "auto" },
    { at: "/filter/temporal", label: "Frames on each side that lend samples", kind: "choice", of: ["auto", "none", "1", "2"], otherwise: "auto" }] },
  { title: "Layers", fields: [{ at: "/layers", label: "Layers", kind: "several", of: LAYERS, otherwise: ["beauty"] }] },
  { title: "Frames and priority", fields: [
    { at: "/frames/first", label: "First frame", kind: "integer", min: 0, max: 1073741824, otherwise: 1 },
    { at: "/frames/last", label: "Last frame", kind: "integer", min: 0, max: 1073741824 },
    { at: "/scene/animation", label: "Animation", kind: "word", longest: 255, otherwise: null, hint: "a name in the scene; none: all play" },
    { at: "/scene/time_s", label: "Time that all frames show", unit: "s", kind: "number", min: -1e9, max: 1e9, otherwise: null },
    { at: "/fps", label: "Frames per second", kind: "number", min: 0.001, max: 1000, otherwise: 24 },
    { at: "/start_time_s", label: "Time at frame 1", unit: "s", kind: "number", min: -1e9, max: 1e9, otherwise: 0 },
    { at: "/priority", label: "Priority", kind: "integer", min: -100, max: 100, otherwise: 0 },
    { at: "/live", label: "Live: camera and objects can be moved", kind: "flag", otherwise: false }] },
];

// GLB files that show an extension each, as Khronos' sample models of it do: five balls, or sheets, of which each has
// more of it than the one before.
import { balls } from "./ball_row.mjs";

const steps = [0, 0.25, 0.5, 0.75, 1];
const matt = (color, roughness = 0.8) => ({ baseColorFactor: [...color, 1], metallicFactor: 0, roughnessFactor: roughness });
const glass = { KHR_materials_transmission: { transmissionFactor: 1 } };

const sheen = steps.map((x) => ({ pbrMetallicRoughness: matt([0.25, 0.02, 0.03]),
  extensions: { KHR_materials_sheen: { sheenColorFactor: [0.9, 0.7, 0.75], sheenRoughnessFactor: 0.1 + 0.8 * x } } }));
const films = (metallicFactor) => steps.map((x) => ({
  pbrMetallicRoughness: { baseColorFactor: metallicFactor ? [0.8, 0.8, 0.8, 1] : [0.02, 0.02, 0.02, 1], metallicFactor, roughnessFactor: 0.15 },
  extensions: { KHR_materials_iridescence: { iridescenceFactor: 1, iridescenceIor: metallicFactor ? 1.3 : 1.8, iridescenceThicknessMaximum: 100 + 600 * x } } }));
const prisms = steps.map((x) => ({ pbrMetallicRoughness: matt([1, 1, 1], 0),
  extensions: { ...glass, KHR_materials_ior: { ior: 1.7 }, KHR_materials_volume: { thicknessFactor: 1 }, KHR_materials_dispersion: { dispersion: 10 * x } } }));
const leaves = steps.map((x) => ({ doubleSided: true, pbrMetallicRoughness: matt([0.2, 0.6, 0.1]),
  extensions: { KHR_materials_diffuse_transmission: { diffuseTransmissionFactor: x, diffuseTransmissionColorFactor: [0.9, 0.8, 0.1] } } }));
const coats = steps.map((x) => ({ pbrMetallicRoughness: matt([0.5, 0.02, 0.02], 0.5),
  extensions: { KHR_materials_clearcoat: { clearcoatFactor: x } } }));

// By label.
export const lobes = {
  "clear coat 0-1": balls(coats), "sheen, rough 0.1-0.9": balls(sheen),
  "film 100-700 nm, black": balls(films(0)), "film 100-700 nm, metal": balls(films(1)),
  "dispersion 0-10": balls(prisms, { behind: true }), "lets through 0-1": balls(leaves, { lamp: true }),
};

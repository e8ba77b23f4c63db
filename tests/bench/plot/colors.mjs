// How series look. Colours keep a contrast of 3:1 to white and of lightness among neighbours, and are told
// apart by people who do not see red or green as others do (after Okabe and Ito 2008, darkened); every
// series has a mark of its own besides, and its name stands at its line.
const LOOKS = {
  average: ["#6b6b6b", "circle"], paths: ["#00798c", "wedge"], axis_aligned: ["#b35900", "square"], sheared: ["#0060ad", "diamond"],
  constant: ["#b35900", "square"], linear: ["#00755e", "triangle"], blend: ["#a0457e", "wedge"], auto: ["#111111", "diamond"],
  adaptive: ["#c23b22", "plus"], extra: ["#7a3e9d", "triangle"], sheared_4d: ["#00755e", "cross"], none: ["#6b6b6b", "circle"],
  OIDN: ["#b35900", "square"] };
const OTHERS = [["#0060ad", "circle"], ["#b35900", "square"], ["#00755e", "triangle"], ["#a0457e", "diamond"], ["#00798c", "wedge"], ["#111111", "plus"]];

// The look of a series by its name, or by its place among others.
export function lookOf(name, place) {
  const [color, mark] = LOOKS[name] ?? OTHERS[place % OTHERS.length];
  return { color, mark };
}

// Stages of a frame, in the order of the frame, from statistics' cpu_s: what a reader can tell apart.
export const STAGES = [
  { name: "scene", of: ["import", "build"], color: "#7d7d7d", ink: "#fff" },
  { name: "trace", of: ["trace"], color: "#0060ad", ink: "#fff" },
  { name: "transport", of: ["pack", "decode"], color: "#8ec1e8", ink: "#111" },
  { name: "resolve", of: ["reconstruct"], color: "#f0d27a", ink: "#111" },
  { name: "filters", of: ["shadow", "indirect", "glossy", "lens", "lens_relight"], color: "#c2410c", ink: "#fff" },
  { name: "files", of: ["encode"], color: "#4c9a7a", ink: "#111" },
  { name: "coordinate", of: ["coordinate"], color: "#5b3a73", ink: "#fff" },
  { name: "other", of: [], color: "#d4d4d4", ink: "#111" }];

// cpu_s as [[stage, seconds], ...]; "other" is what no stage has of the total.
export function stagesOf(cpu_s) {
  const known = STAGES.map(({ of }) => of.reduce((sum, name) => sum + (cpu_s[name] ?? 0), 0));
  known[known.length - 1] = Math.max(0, (cpu_s.total ?? 0) - known.reduce((a, b) => a + b, 0));
  return STAGES.map((stage, i) => ({ ...stage, seconds: known[i] }));
}

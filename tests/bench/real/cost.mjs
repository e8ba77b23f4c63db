// CPU seconds of a frame by what they were spent on. Stages that are none of these are filters, whatever new ones
// are called.
const OTHERS = ["import", "build", "trace", "pack", "decode", "reconstruct", "encode", "coordinate", "total"];
const MADE_OF = ["trace", "pack", "decode", "reconstruct"];

const sum = (values) => values.reduce((a, b) => a + b, 0);

export const filterSeconds = (cpu_s) => sum(Object.keys(cpu_s).filter((stage) => !OTHERS.includes(stage)).map((stage) => cpu_s[stage]));

// From samples to the picture: neither the scene's import nor files.
export const pictureSeconds = (cpu_s) => sum(MADE_OF.map((stage) => cpu_s[stage] ?? 0)) + filterSeconds(cpu_s);

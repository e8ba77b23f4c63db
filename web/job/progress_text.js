// How far a job is, in words. 100 % is said of finished jobs alone.

// The first frame of a document: of {first, last}, or of a list such as "1-10,20-40x2".
export const firstFrame = (document) => {
  const frames = document?.frames;
  return typeof frames === "string" ? Number.parseInt(frames, 10) : frames?.first ?? 1;
};

export const ENDED = new Set(["finished", "failed", "cancelled"]);

export const percent = (state, fraction = 0) => state === "finished" ? 100 : Math.min(99, Math.floor(fraction * 100));

const duration = (s) => s < 90 ? [Math.ceil(s), "s"] : s < 5400 ? [Math.ceil(s / 60), "min"] : [(s / 3600).toFixed(1), "h"];

// "12 s", or "10 to 40 s" where that is all that can be told of it; nothing when there is no telling.
export const etaText = ({ eta_s: eta, eta_range_s: range } = {}) => {
  if (!Number.isFinite(eta) && !range) return "";
  const [[least, lower], [most, unit]] = (Number.isFinite(eta) ? [eta, eta] : range).map(duration);
  if (least === most && lower === unit) return `${most} ${unit}`;
  return `${least}${lower === unit ? "" : ` ${lower}`} to ${most} ${unit}`;
};

export const timeLeft = (job) => {
  const text = ENDED.has(job.state) ? "" : etaText(job.progress ?? {});
  return text && `${text} left`;
};

// What people call a job: its name, or the end of its id.
export const nameOf = (job) => job.name ?? `Job ${job.id.slice(-8)}`;

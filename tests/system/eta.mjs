// How right the time left of a job was told: follows its events to the end and then looks back.
//   node tests/system/eta.mjs URL JOB.json|ID [--print]
// Prints {total_s, events, ranged, within, told, right, worst}: progress events from the tenth per cent of the time on, those
// that told a range and those whose range had what was truly left; those that told a time, and those right within a third.
import { readFileSync } from "node:fs";

export const WITHIN = 1 / 3, FROM = 0.1;
const SLACK_S = 0.5; // times are told in tenths of seconds, events come four a second

// events: [{t, eta, range}] in seconds, end: when the job finished, start: when its first frame was begun.
export function judge(events, start, end) {
  const from = start + FROM * (end - start);
  const later = events.filter(({ t }) => t >= from && t < end);
  const told = later.filter(({ eta }) => Number.isFinite(eta)), ranged = later.filter(({ range }) => range);
  const within = ranged.filter(({ t, range: [least, most] }) => least - SLACK_S <= end - t && end - t <= most + SLACK_S);
  const error = ({ t, eta }) => Math.max(0, Math.abs(eta - (end - t)) - SLACK_S) / (end - t);
  const right = told.filter((one) => error(one) <= WITHIN);
  return { total_s: end - start, events: later.length, ranged: ranged.length, within: within.length,
    told: told.length, right: right.length, worst: Math.max(0, ...told.map(error)) };
}

export async function follow(url, id, print) {
  const answer = await fetch(`${url}/v1/jobs/${id}/events`);
  const events = [];
  let text = "", start = null, end = null;
  for await (const chunk of answer.body) {
    text += Buffer.from(chunk).toString();
    const parts = text.split("\n\n");
    text = parts.pop();
    for (const part of parts) {
      const name = /^event: (.*)$/m.exec(part)?.[1], data = /^data: (.*)$/m.exec(part)?.[1];
      if (!data) continue;
      const now = performance.now() / 1000, body = JSON.parse(data);
      if (body.state === "running" || body.state === "rendering") start ??= now;
      if (name === "progress") {
        start ??= now;
        events.push({ t: now, eta: body.eta_s ?? NaN, range: body.eta_range_s, fraction: body.fraction });
      }
      if (body.state === "finished" && name === "state") end = now;
    }
    if (end) break;
  }
  for (const { t, eta, range, fraction } of print ? events : [])
    console.error(`${((t - start) / (end - start)).toFixed(3)} ${(t - start).toFixed(2)} fraction ${fraction} eta ${eta} of ${range} true ${(end - t).toFixed(2)}`);
  return judge(events, start, end);
}

if (process.argv[1]?.endsWith("eta.mjs")) {
  const [url, id] = process.argv.slice(2);
  console.log(JSON.stringify(await follow(url, id, process.argv.includes("--print"))));
}

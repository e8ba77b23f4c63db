// Is told of the ends of jobs, as somebody's own program would be: checks the signature, and fails as its path says.
//   node tests/system/webhook_receiver.mjs KEY_FILE LOG_FILE CLOSED_FILE
// Prints its port. Each call is a line of the log: {path, valid, answer, body}.
import { createHmac, timingSafeEqual } from "node:crypto";
import { appendFileSync, existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";

const [keyFile, logFile, closedFile] = process.argv.slice(2);
const key = Buffer.from(readFileSync(keyFile, "utf8").trim(), "hex");
const calls = new Map();

function isValid(headers, body) {
  const time = headers["shearwater-timestamp"] ?? "", sent = Buffer.from(headers["shearwater-signature"] ?? "");
  const own = Buffer.from(`sha256=${createHmac("sha256", key).update(`${time}.${body}`).digest("hex")}`);
  return sent.length === own.length && timingSafeEqual(sent, own) && Math.abs(Date.now() / 1000 - Number(time)) < 60;
}

const ANSWERS = {
  "/flaky": (count) => [500, 302][count] ?? 204, // an error, a redirect, then it is taken
  "/late": () => existsSync(closedFile) ? 503 : 200,
  "/hang": () => 0,
};

createServer((request, response) => {
  let body = "";
  request.on("data", (chunk) => { body += chunk; });
  request.on("end", () => {
    const count = calls.get(request.url) ?? 0, answer = (ANSWERS[request.url] ?? (() => 404))(count);
    calls.set(request.url, count + 1);
    appendFileSync(logFile, `${JSON.stringify({ path: request.url, method: request.method, valid: isValid(request.headers, body), answer, body: JSON.parse(body || "null") })}\n`);
    if (answer === 0) return;
    response.writeHead(answer, answer === 302 ? { Location: "/elsewhere" } : {}).end();
  });
}).listen(0, "127.0.0.1", function () { console.log(this.address().port); });

// Somebody on the line between a worker and its coordinator: passes bytes on, keeps what it has seen, and
// flips a bit of what the worker sends, if told to.
//   tap.mjs TO_PORT SEEN_FILE [FLIP_AT_BYTE]      prints its own port
import { createConnection, createServer } from "node:net";
import { appendFileSync } from "node:fs";

const [to, seen, flipAt] = process.argv.slice(2);
let passed = 0;
const server = createServer((worker) => {
  const coordinator = createConnection(Number(to), "127.0.0.1");
  const end = () => { worker.destroy(); coordinator.destroy(); };
  for (const [from, into] of [[worker, coordinator], [coordinator, worker]]) {
    from.on("data", (bytes) => {
      appendFileSync(seen, bytes);
      if (from === worker && flipAt !== undefined) {
        const at = Number(flipAt) - passed;
        if (at >= 0 && at < bytes.length) bytes[at] ^= 1;
        passed += bytes.length;
      }
      into.write(bytes);
    });
    from.on("close", end);
    from.on("error", end);
  }
});
server.listen(0, "127.0.0.1", () => console.log(server.address().port));

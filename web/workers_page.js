// The page of the workers: their names, pace and tiles, and draining them.
import { drainWorker, workersUrl } from "./api.js";
import { showConnection } from "./connection.js";
import { markPage } from "./navigation.js";
import { Poll } from "./poll.js";
import { WorkerRows } from "./worker_rows.js";

const $ = (id) => document.getElementById(id);
const rows = new WorkerRows($("rows"), drain);
// Rates are as new as a worker's last beat.
const poll = new Poll(show, showConnection, { quickMs: 1000, slowMs: 1000 });

function show({ workers }) {
  rows.show(workers);
  const threads = workers.reduce((sum, worker) => sum + worker.threads, 0);
  const text = workers.length === 0 ? "No worker is connected. Start one: shearwater-worker."
    : `${workers.length === 1 ? "1 worker" : `${workers.length} workers`}, ${threads === 1 ? "1 thread" : `${threads} threads`}.`;
  if ($("count").textContent !== text) $("count").textContent = text;
}

// What the roster says afterwards is what is told: a worker may be gone before it is drained.
async function drain(worker, wanted) {
  $("problem").hidden = true;
  try {
    const { name, state } = await drainWorker(worker.id, wanted);
    $("said").textContent = `${name} is ${state}`;
  } catch (error) {
    $("problem").hidden = false;
    $("problem").textContent = `${worker.name}: ${error.message}`;
  }
  await poll.look();
}

markPage("workers.html");
poll.follow(workersUrl);

// The page of all jobs. What it shows is what its address says: state, name, label, text and the page of
// the list.
import { jobsUrl } from "./api.js";
import { showConnection } from "./connection.js";
import { JobRows } from "./job/job_rows.js";
import { markPage } from "./navigation.js";
import { Poll } from "./poll.js";

const $ = (id) => document.getElementById(id);
const ROWS = 50;
const rows = new JobRows($("rows"));
const poll = new Poll(show, (state, error) => {
  // What the server refuses (an address by hand) is said; that it is away, the header says.
  const refused = Boolean(error?.status);
  showConnection(refused ? "live" : state, error);
  $("problem").hidden = !refused;
  $("problem").textContent = refused ? error.message : "";
});
const PACE = { quickMs: 1000, slowMs: 4000 };
const PACE_OF_TEXT = { quickMs: 5000, slowMs: 20000 }; // all documents are read for each look

const view = () => {
  const { state, name, label, text, cursor } = Object.fromEntries(new URLSearchParams(location.search));
  return { state, name, label, text, cursor };
};
const address = (query) => {
  const parts = new URLSearchParams(Object.entries(query).filter(([, value]) => value)).toString();
  return parts ? `jobs.html?${parts}` : "jobs.html";
};

function show({ jobs, next }) {
  const { cursor, ...filters } = view();
  const filtered = Object.values(filters).some(Boolean);
  rows.show(jobs);
  const sum = jobs.length === 1 ? "1 job" : `${jobs.length} jobs`;
  $("count").textContent = jobs.length > 0 ? `${sum} on this page${next ? ", older ones follow" : ""}.`
    : filtered ? "No job matches." : cursor ? "There are no older jobs." : "No jobs yet.";
  $("older").hidden = !next;
  if (next) $("older").href = address({ ...filters, cursor: next });
  $("newest").hidden = !cursor;
  $("newest").href = address(filters);
}

// The address is all that is remembered.
function route() {
  const { state, name, label, text, cursor } = view();
  $("state").value = state ?? "";
  if ($("state").selectedIndex < 0) $("state").value = "";
  for (const [id, value] of Object.entries({ name, label, text })) $(id).value = value ?? "";
  $("clear").hidden = !state && !name && !label && !text && !cursor;
  const which = [state, name && `“${name}”`, label && `label ${label}`, text && `“${text}”`, cursor && "older"].filter(Boolean).join(", ");
  document.title = `Jobs${which ? `: ${which}` : ""} · Shearwater`;
  Object.assign(poll, text ? PACE_OF_TEXT : PACE);
  poll.follow(jobsUrl({ limit: ROWS, state, name, label, text, cursor }));
}

function go(to) {
  history.pushState(null, "", to);
  route();
}

$("filters").addEventListener("submit", (event) => {
  event.preventDefault();
  go(address(Object.fromEntries(["state", "name", "label", "text"].map((id) => [id, $(id).value.trim()]))));
});
$("state").addEventListener("change", () => $("filters").requestSubmit());
for (const id of ["older", "newest", "clear"])
  $(id).addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button > 0) return;
    event.preventDefault();
    go($(id).getAttribute("href"));
    scrollTo(0, 0);
    $("content").focus({ preventScroll: true });
  });
addEventListener("popstate", route);
markPage("jobs.html");
route();

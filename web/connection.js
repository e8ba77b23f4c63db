// The line in the header of each page that says whether the server answers.

const WORDS = { live: "connected", connecting: "connecting", lost: "no connection, trying again" };

export function showConnection(state, error) {
  const element = document.getElementById("connection");
  if (element.dataset.state === state) return;
  element.dataset.state = state;
  element.textContent = WORDS[state];
  element.title = error?.message ?? "";
}

// Signing in, where the server asks for tokens. The token goes out once, in a header; what stays is a
// cookie that no script can read. A user who is refused is asked for one; a user who is in may sign out.
import { make } from "./elements.js";

let dialog = null;

// A request of the page was refused for want of a token: asks for one, and begins the page anew.
export function askForToken() {
  if (dialog?.open) return;
  dialog ??= makeDialog();
  dialog.showModal();
}

function makeDialog() {
  const token = make("input", { id: "sign-in-token", type: "password", autocomplete: "current-password", required: true, spellcheck: "false" });
  const problem = make("p", { id: "sign-in-problem", role: "alert", hidden: true });
  const button = make("button", { type: "submit" }, "Sign in");
  const form = make("form", { method: "dialog" },
    make("h2", { id: "sign-in-title" }, "Sign in"),
    make("p", {}, "This server needs an access token. Its operator creates one with “shearwater token”."),
    make("p", {}, make("label", { for: "sign-in-token" }, "Token "), token), problem, make("div", { class: "bar" }, button));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    problem.hidden = button.disabled = true;
    try {
      await signIn(token.value.trim());
      location.reload();
    } catch (error) {
      problem.textContent = error.message;
      problem.hidden = button.disabled = false;
      token.focus();
    }
  });
  const made = make("dialog", { id: "sign-in", "aria-labelledby": "sign-in-title" }, form);
  document.body.append(made);
  return made;
}

async function signIn(token) {
  // Headers hold no other letters, and fetch would refuse them in words of its own.
  if (!/^[\w.~+/=-]{20,256}$/.test(token)) throw new Error("This is not a token: a token has at least 20 letters and digits.");
  const response = await fetch("/v1/session", { method: "POST", headers: { Authorization: `Bearer ${token}` }, cache: "no-store" });
  if (response.status === 401) throw new Error("The server does not know this token.");
  if (!response.ok) throw new Error(`The server answered ${response.status}.`);
}

// Puts the user's name and the sign-out into the header of each page.
async function showWho() {
  const response = await fetch("/v1/session", { cache: "no-store" });
  const who = response.ok ? await response.json() : {};
  if (!who.tokens || !who.role) return;
  const out = make("button", { id: "sign-out", type: "button" }, "Sign out");
  out.addEventListener("click", async () => {
    await fetch("/v1/session", { method: "DELETE" });
    location.reload();
  });
  document.querySelector("header").append(make("p", { id: "who", title: `role: ${who.role}` }, `${who.name} of ${who.tenant} `, out));
}
showWho().catch(() => { /* the connection says so */ });

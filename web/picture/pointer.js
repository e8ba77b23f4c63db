// JSON Pointers (RFC 6901) into a document.

const parts = (pointer) => pointer.split("/").slice(1).map((part) => part.replaceAll("~1", "/").replaceAll("~0", "~"));

export function valueAt(document, pointer) {
  let at = document;
  for (const part of parts(pointer)) {
    if (at === null || typeof at !== "object") return undefined;
    at = at[part];
  }
  return at;
}

// Objects on the way are made where they are missing.
export function setAt(document, pointer, value) {
  const names = parts(pointer), last = names.pop();
  let at = document;
  for (const name of names) {
    if (at[name] === null || typeof at[name] !== "object") at[name] = {};
    at = at[name];
  }
  at[last] = value;
}

// Objects that it leaves empty go, too, so that a document says only what was asked for.
export function removeAt(document, pointer) {
  const names = parts(pointer), last = names.pop();
  const above = names.reduce((at, name) => at !== null && typeof at === "object" ? at[name] : undefined, document);
  if (above === null || typeof above !== "object") return;
  delete above[last];
  if (names.length === 1 && Object.keys(above).length === 0) delete document[names[0]];
}

// Elements by calls: the pages' policy lets no markup with styles or handlers in, and text stays text.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === null || value === undefined) continue;
    element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export const make = (tag, attributes = {}, ...children) => fill(document.createElement(tag), attributes, children);
export const makeSvg = (tag, attributes = {}, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);

// Changes text only where it differs, so that selections and screen readers are left in peace.
export function setText(element, text) { if (element.textContent !== text) element.textContent = text; }

// [[name, value], ...] as the children of a <dl>.
export const definitions = (rows) => rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]);

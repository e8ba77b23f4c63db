// Which of the pages this is.
export function markPage(name) {
  for (const link of document.querySelectorAll("nav.pages a"))
    if (link.getAttribute("href") === name) link.setAttribute("aria-current", "page");
}

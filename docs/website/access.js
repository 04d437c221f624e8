// What the theme leaves out for readers with a keyboard or a screen reader: regions of one name, and tables that scroll.
"use strict"

function correct() {
  document.querySelectorAll("nav.md-code__nav").forEach((nav, number) => label(nav, `Code block ${number + 1}`))
  document.querySelectorAll("nav.md-nav[data-md-level='2']").forEach((nav, number) => label(nav, `Pages, part ${number + 1}`))
  for (const table of document.querySelectorAll(".md-typeset__scrollwrap")) table.tabIndex = 0
  for (const empty of document.querySelectorAll("th:empty")) empty.replaceWith(document.createElement("td"))
}

function label(element, text) {
  element.removeAttribute("aria-labelledby")
  element.setAttribute("aria-label", text)
}

new MutationObserver(correct).observe(document.body, { childList: true, subtree: true })
correct()

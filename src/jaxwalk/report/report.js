// Folds sections, opens the one that an address names, and marks in the contents which one is in view.

const sections = [...document.querySelectorAll("details.section")];
const fold = document.querySelector("[data-fold]");

fold.addEventListener("click", () => {
  const open = !sections.some((section) => section.open);
  for (const section of sections) section.open = open;
  fold.textContent = open ? "Fold all sections" : "Unfold all sections";
});

function unfold() {
  const target = document.getElementById(location.hash.slice(1)), section = target?.closest("details.section");
  if (!section || section.open) return;
  section.open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", unfold);
unfold();

// The lowest section that begins in the upper third of the window is the one being read.
const links = [...document.querySelectorAll(".contents a")].map((link) => [link, document.getElementById(link.hash.slice(1))]);
let waiting = false;
function mark() {
  waiting = false;
  const begun = links.filter(([, target]) => target.getBoundingClientRect().top < innerHeight / 3);
  const [current] = begun.at(-1) ?? links[0];
  for (const [link] of links) link === current ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current");
}
addEventListener("scroll", () => waiting || (waiting = requestAnimationFrame(mark)), { passive: true });
mark();

// The gallery of failures: every incident a card, one click from its replay.

const AVOIDABLE = {
  driver: "avoidable by the driver", either: "avoidable by either", pedestrian: "avoidable by the pedestrian", unavoidable: "unavoidable",
};
const WHO = { jaywalk: "jaywalker", crosswalk: "crosswalk user", sidewalk: "pedestrian on the sidewalk" };
const SHOWN = 12; // cards at first, and with each "Show more"
const CLOSE_UP = 26; // a card's picture is so many metres wide

class Gallery {
  constructor(element, data) {
    this.element = element;
    this.data = data;
    this.find = (selector) => element.querySelector(selector);
    this.form = this.find("form");
    this.player = new Player(this.find(".player"), data);
    this.avoidable = this.situation = "";
    this.shown = SHOWN;
    this.pictures = new IntersectionObserver((seen) => seen.forEach((one) => one.isIntersecting && this.#picture(one.target)), { rootMargin: "200px" });
    this.#offerCells();
    this.#listen();
    this.update();
  }

  get wanted() {
    return Object.fromEntries(["cell", "kind", "contact", "sort"].map((name) => [name, this.form.elements[name].value]));
  }

  #offerCells() {
    const cells = [...new Set(this.data.episodes.map(cellOf))];
    this.form.elements.cell.append(new Option("all", ""), ...cells.map((cell) => new Option(cell, cell)));
  }

  #listen() {
    this.form.addEventListener("change", () => this.#changed());
    this.form.addEventListener("submit", (event) => event.preventDefault());
    this.find(".more").addEventListener("click", () => ((this.shown += SHOWN), this.update()));
    const dialog = this.find("dialog");
    dialog.addEventListener("close", () => {
      this.player.pause();
      history.replaceState(null, "", location.pathname + location.search);
    });
    dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
    dialog.addEventListener("keydown", (event) => {
      if (event.key === "n") this.#go(1);
      else if (event.key === "b") this.#go(-1);
      else this.player.key(event);
    });
    for (const button of dialog.querySelectorAll("[data-go]")) {
      button.addEventListener("click", () => (button.dataset.go === "close" ? dialog.close() : this.#go(Number(button.dataset.go))));
    }
  }

  #changed() {
    this.avoidable = this.situation = "";
    this.shown = SHOWN;
    this.update();
  }

  // Show a driver's collisions among a population; called by links elsewhere on the page.
  choose(cell, kind = "collision") {
    Object.assign(this.form.elements.cell, { value: cell });
    Object.assign(this.form.elements.kind, { value: kind });
    Object.assign(this.form.elements.contact, { value: "" });
    this.#changed();
  }

  // The incidents that are asked for, in order; sorting is stable, and they come by severity.
  list() {
    const { cell, kind, contact, sort } = this.wanted;
    const fits = (one) => (!cell || cellOf(this.#entry(one)) === cell) && (!kind || one.kind === kind) && (!contact || one.contact === contact);
    const order = {
      severity: (one) => (one.kind === "collision" ? -(one.risk ?? 0) : 1 + (one.ttc ?? 99)), type: (one) => Object.keys(WHO).indexOf(one.contact),
      avoidability: (one) => (Object.keys(AVOIDABLE).indexOf(one.avoidable) + 5) % 5, scenario: (one) => this.#entry(one).scenario,
    };
    const bySeverity = this.data.incidents.filter(fits).sort((a, b) => order.severity(a) - order.severity(b));
    return bySeverity.sort((a, b) => order[sort](a) - order[sort](b));
  }

  update() {
    const fitting = this.list();
    this.#chips(".chips:not(.situations)", fitting.filter((one) => one.avoidable), (one) => one.avoidable, AVOIDABLE, "avoidable");
    const kept = fitting.filter((one) => !this.avoidable || one.avoidable === this.avoidable);
    this.#chips(".situations", kept, situation, {}, "situation");
    this.chosen = kept.filter((one) => !this.situation || situation(one) === this.situation);
    this.find(".count").textContent = this.#counted();
    this.find(".incidents").replaceChildren(...this.chosen.slice(0, this.shown).map((one) => this.#card(one)));
    this.find(".more").hidden = this.chosen.length <= this.shown;
  }

  #counted() {
    const hits = this.chosen.filter((one) => one.kind === "collision").length, misses = this.chosen.length - hits;
    const count = (n, one, many) => `${n} ${n === 1 ? one : many}`;
    return `${count(hits, "collision", "collisions")} and ${count(misses, "near miss", "near misses")}. A click plays one.`;
  }

  // A button for each group, the largest first, that shows it alone.
  #chips(place, some, group, names, field) {
    const counts = new Map();
    for (const one of some) counts.set(group(one), (counts.get(group(one)) ?? 0) + 1);
    const groups = [...counts].sort((a, b) => b[1] - a[1]).slice(0, 12);
    this.find(place).replaceChildren(...groups.map(([name, count]) => {
      const chip = document.createElement("button");
      chip.type = "button";
      chip.textContent = `${names[name] ?? name} (${count})`;
      chip.setAttribute("aria-pressed", String(this[field] === name));
      chip.addEventListener("click", () => {
        this[field] = this[field] === name ? "" : name;
        if (field === "avoidable") this.situation = "";
        this.update();
        [...this.find(place).children].find((other) => other.textContent === chip.textContent)?.focus();
      });
      return chip;
    }));
  }

  #entry = (incident) => this.data.episodes[incident.episode];

  #card(incident) {
    const item = document.createElement("li"), button = document.createElement("button"), canvas = document.createElement("canvas");
    const entry = this.#entry(incident);
    button.type = "button";
    canvas.setAttribute("aria-hidden", "true");
    canvas.incident = incident;
    const lines = [["what", capital(situation(incident))], ["how", severity(incident)], ["who", `${cellOf(entry)}, scenario ${entry.scenario}, ${incident.t.toFixed(1)} s`]];
    button.append(canvas, ...lines.map(([name, text]) => Object.assign(document.createElement("span"), { className: name, textContent: text })));
    button.addEventListener("click", () => this.watch(incident));
    item.append(button);
    this.pictures.observe(canvas);
    return item;
  }

  async #picture(canvas) {
    this.pictures.unobserve(canvas);
    const incident = canvas.incident, entry = this.#entry(incident);
    const episode = await Episode.load(entry, this.data.dt), map = this.data.maps[entry.map];
    const drawing = new Drawing(canvas, map), { x, y } = episode.at(incident.t).car;
    const fit = Math.min(canvas.clientWidth / map.width, canvas.clientHeight / map.height);
    drawing.view = { x, y, zoom: canvas.clientWidth / CLOSE_UP / fit };
    drawing.draw(episode, incident.t, { hidden: true, trails: true });
  }

  // Play an incident from a little before it.
  async watch(incident) {
    this.current = incident;
    this.find("#watched").textContent = capital(situation(incident));
    const dialog = this.find("dialog");
    if (!dialog.open) dialog.showModal();
    this.player.set("follow", true);
    await this.player.show([this.#entry(incident)], incident.t - this.data.lead);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.player.play();
  }

  // Any episode of the page at a time, as an address asks for it.
  async open({ entry, time }) {
    this.find("#watched").textContent = `Scenario ${entry.scenario}`;
    if (!this.find("dialog").open) this.find("dialog").showModal();
    await this.player.show([entry], time);
  }

  #go(by) {
    const next = this.chosen[this.chosen.indexOf(this.current) + by];
    if (next) this.watch(next);
  }
}

const cellOf = (entry) => `${entry.driver} among ${entry.pedestrians}`;
const situation = (one) => `${WHO[one.contact]} ${one.side === "standing" ? "standing" : one.side}, car ${one.car}`;
const capital = (text) => text[0].toUpperCase() + text.slice(1);

function severity(one) {
  if (one.kind === "near miss") return `Near miss: ${one.ttc === null ? "" : `${one.ttc.toFixed(1)} s to collision, `}${one.nearest.toFixed(1)} m`;
  const who = one.avoidable ? `, ${AVOIDABLE[one.avoidable]}` : "";
  if (!one.moving) return `Walked into the standing car${who}`;
  return `Hit at ${one.speed.toFixed(1)} m/s, ${Math.round(100 * one.risk)} % risk of serious injury${who}`;
}

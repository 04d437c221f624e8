// The gallery of failures: every incident is a card, and a click on it plays the replay.

const AVOIDABLE = {
  driver: "avoidable by the driver", either: "avoidable by either", pedestrian: "avoidable by the pedestrian", unavoidable: "unavoidable",
};
const WHO = { jaywalk: "jaywalker", crosswalk: "crosswalk user", sidewalk: "pedestrian on the sidewalk" };
const SHOWN = 12; // cards at first, and with each "Show more"
const NEAR = "300px"; // pictures are drawn this far outside the window
const CLOSE_UP = 26; // width of a card's picture [m]

class Gallery {
  constructor(element, data) {
    this.element = element;
    this.data = data;
    this.find = (selector) => element.querySelector(selector);
    this.form = this.find("form");
    this.player = new Player(this.find(".player"), data);
    this.avoidable = this.situation = "";
    this.shown = SHOWN;
    this.#offerCells();
    this.#listen();
    // Pictures are drawn when they come into view: a page may have hundreds.
    this.seen = new IntersectionObserver((all) => this.#drawSeen(all), { rootMargin: NEAR });
    this.update();
    new ResizeObserver(() => this.#pictures()).observe(element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#pictures());
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
    dialog.addEventListener("close", () => this.player.leave());
    dialog.addEventListener("pointerdown", (event) => event.target === dialog && isOutside(event, dialog) && dialog.close());
    dialog.addEventListener("keydown", (event) => this.player.key(event, { n: () => this.#go(1), b: () => this.#go(-1) }));
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

  // Returns the chosen incidents in order. Sorting is stable, and the data is ordered by severity.
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
    this.#pictures();
  }

  #counted() {
    const hits = this.chosen.filter((one) => one.kind === "collision").length, misses = this.chosen.length - hits;
    const count = (n, one, many) => `${n} ${n === 1 ? one : many}`;
    return `${count(hits, "collision", "collisions")} and ${count(misses, "near miss", "near misses")}.${this.chosen.length ? " A click plays one." : ""}`;
  }

  // Adds a button for each group, the largest first, which shows only that group.
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
    return item;
  }

  #pictures() {
    this.seen.disconnect();
    for (const canvas of this.element.querySelectorAll(".incidents canvas")) this.seen.observe(canvas);
  }

  #drawSeen(observed) {
    for (const { target } of observed.filter((one) => one.isIntersecting)) {
      this.seen.unobserve(target);
      this.#picture(target);
    }
  }

  async #picture(canvas) {
    const incident = canvas.incident, entry = this.#entry(incident);
    const episode = await Episode.load(entry, this.data.dt), map = this.data.maps[entry.map];
    const drawing = new Drawing(canvas, map), { x, y } = episode.at(incident.t).car;
    const fit = Math.min(canvas.clientWidth / map.width, canvas.clientHeight / map.height);
    drawing.view = { x, y, zoom: canvas.clientWidth / CLOSE_UP / fit };
    drawing.draw(episode, incident.t, { hidden: true, sight: true, trails: true });
  }

  // Plays an incident from shortly before it.
  async watch(incident) {
    this.player.set("follow", true);
    const shown = await this.#show(incident, capital(situation(incident)), [this.#entry(incident)], incident.t - this.data.lead);
    if (shown && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.player.play();
  }

  // Shows the episodes and the time that an address names.
  async open({ entries, time }) {
    if (!entries.length) {
      this.find(".count").textContent = "This page doesn't have the episode of the link.";
      return;
    }
    const incident = this.data.incidents.find((one) => this.#entry(one) === entries[0]);
    await this.#show(incident, `Scenario ${entries[0].scenario}`, entries, time);
  }

  // Returns whether they are shown; false if something else was opened meanwhile.
  async #show(incident, title, entries, time) {
    const dialog = this.find("dialog");
    this.current = incident;
    this.find("#watched").textContent = title;
    if (!dialog.open) dialog.showModal();
    return (await this.player.show(entries, time)) && dialog.open;
  }

  #go(by) {
    const here = this.chosen.indexOf(this.current), next = here < 0 ? undefined : this.chosen[here + by];
    if (next) this.watch(next);
  }
}

function isOutside({ clientX: x, clientY: y }, element) {
  const box = element.getBoundingClientRect();
  return x < box.left || x > box.right || y < box.top || y > box.bottom;
}

const cellOf = (entry) => `${entry.driver} among ${entry.pedestrians}`;
const situation = (one) => `${WHO[one.contact]} ${one.side === "standing" ? "standing" : one.side}, car ${one.car}`;
const capital = (text) => text[0].toUpperCase() + text.slice(1);

function severity(one) {
  if (one.kind === "near miss" && one.nearest === 0) return "Contact by the car's footprint, which ends no episode here";
  if (one.kind === "near miss") return `Near miss: ${one.ttc.toFixed(1)} s to collision, came within ${one.nearest.toFixed(1)} m`;
  const who = one.avoidable ? `, ${AVOIDABLE[one.avoidable]}` : "";
  if (!one.moving) return `Walked into the standing car${who}`;
  return `Hit at ${one.speed.toFixed(1)} m/s, ${Math.round(100 * one.risk)} % risk of serious injury${who}`;
}

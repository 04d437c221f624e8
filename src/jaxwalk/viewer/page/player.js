// Plays episodes: the controls, keys and touches around the drawings.

const RATES = [0.1, 0.25, 0.5, 1, 2, 4];
const SWITCHES = ["hidden", "plans", "rings", "trails", "follow", "sight"];
const KEYS = { h: "hidden", p: "plans", r: "rings", l: "trails", f: "follow", s: "sight" };

class Player {
  // element: made from player.html; data: the page's document.
  constructor(element, data) {
    this.element = element;
    this.data = data;
    this.time = 0;
    this.playing = false;
    this.episodes = [];
    this.find = (selector) => element.querySelector(selector);
    this.strips = new Strips(this.find(".strips"));
    this.shows = Object.fromEntries(SWITCHES.map((name) => [name, this.find(`[name=${name}]`).checked]));
    this.rate = 1;
    this.digits = Math.max(1, Math.ceil(-Math.log10(data.dt) - 1e-9));
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  // Shows one episode, or several side by side (entries of the page's list), at a time [s]. Returns false if another one
  // was opened meanwhile.
  async show(entries, time = 0) {
    const ticket = (this.ticket = Symbol());
    const episodes = await Promise.all(entries.map((entry) => Episode.load(entry, this.data.dt)));
    if (ticket !== this.ticket) return false;
    this.pause();
    this.entries = entries;
    this.episodes = episodes;
    this.end = Math.max(...episodes.map((episode) => episode.end));
    this.find(".stages").replaceChildren(...episodes.map((episode) => this.#stage(episode)));
    Object.assign(this.find(".scrub"), { step: this.data.dt, max: this.end });
    this.#listEvents();
    this.#offerOthers();
    this.#offer("sight", episodes.some((episode) => episode.delay !== undefined));
    this.#offer("parked", episodes.some((episode) => episode.parked?.length));
    this.seek(time);
    this.element.dispatchEvent(new CustomEvent("shown", { detail: entries }));
    return true;
  }

  #stage(episode) {
    const stage = this.find("template").content.firstElementChild.cloneNode(true);
    const about = episode.about, canvas = stage.querySelector("canvas");
    stage.querySelector("figcaption").textContent =
      `${about.driver} among ${about.pedestrians}, scenario ${about.scenario}: ${ending(about, this.data.dt)}`;
    episode.drawing = new Drawing(canvas, this.data.maps[about.map]);
    episode.canvas = canvas;
    new Touch(canvas, episode.drawing, (view) => this.#look(view));
    return stage;
  }

  // All drawings show the same part of the map.
  #look(view) {
    this.set("follow", false);
    for (const { drawing } of this.episodes) drawing.view = view;
    this.draw();
  }

  seek(time) {
    if (!this.episodes.length) return;
    this.time = Math.min(Math.max(time, 0), this.end);
    this.draw();
    if (!this.playing) this.#settle();
  }

  // Seconds, or the whole steps of the simulation nearest to it.
  step(steps) {
    this.pause();
    this.seek((Math.round(this.time / this.data.dt) + steps) * this.data.dt);
  }

  play() {
    if (!this.episodes.length) return;
    cancelAnimationFrame(this.frame);
    if (this.time >= this.end) this.time = 0;
    this.playing = true;
    this.#showPlaying();
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      this.time = Math.min(this.time + ((now - before) / 1000) * this.rate, this.end);
      before = now;
      this.draw();
      if (this.time >= this.end) this.pause();
      else this.frame = requestAnimationFrame(tick);
    };
    this.frame = requestAnimationFrame(tick);
  }

  pause() {
    cancelAnimationFrame(this.frame);
    this.playing = false;
    this.#showPlaying();
    if (this.episodes.length) this.#settle();
  }

  toggle = () => (this.playing ? this.pause() : this.play());

  #showPlaying() {
    const button = this.find("[data-do=toggle]");
    button.textContent = this.playing ? "❚❚ Pause" : "▶ Play";
  }

  set(name, on) {
    this.shows[name] = on;
    this.find(`[name=${name}]`).checked = on;
    if (name === "follow") for (const { drawing } of this.episodes) drawing.view = null;
  }

  faster(by) {
    const k = Math.min(Math.max(RATES.indexOf(this.rate) + by, 0), RATES.length - 1);
    this.rate = RATES[k];
    this.find("[name=rate]").value = String(this.rate);
  }

  nextEvent() {
    const after = this.episodes[0]?.events.map((event) => event.frame * this.data.dt).find((t) => t > this.time + 0.01);
    if (after !== undefined) {
      this.pause();
      this.seek(after);
    }
  }

  draw() {
    if (!this.episodes.length) return;
    for (const episode of this.episodes) episode.drawing.draw(episode, this.time, this.shows);
    this.strips.draw(this.episodes, this.time, this.end);
    const scrub = this.find(".scrub"), text = `${this.time.toFixed(this.digits)} s`;
    scrub.value = this.time;
    scrub.setAttribute("aria-valuetext", text);
    const speeds = this.episodes.map((episode) => `${episode.at(this.time).car.speed.toFixed(1)} m/s`);
    this.find(".clock").textContent = `${text} of ${this.end.toFixed(1)} s, ${speeds.join(" | ")}`;
  }

  get link() {
    return moment(this.entries, this.time.toFixed(this.digits));
  }

  // Updates the page's address and the description of the picture. The address waits for a pause, because browsers allow
  // only a hundred changes in 30 s.
  #settle() {
    clearTimeout(this.settling);
    this.settling = setTimeout(() => history.replaceState(null, "", this.link), 250);
    this.find(".link").href = this.link;
    for (const episode of this.episodes) episode.canvas.setAttribute("aria-label", inWords(episode, this.time));
  }

  #listEvents() {
    const items = this.episodes[0].events.map((event) => {
      const item = document.createElement("li"), button = document.createElement("button");
      button.type = "button";
      button.textContent = `${(event.frame * this.data.dt).toFixed(1)} s ${SIGNS[event.what]} ${said(event)}`;
      button.addEventListener("click", () => (this.pause(), this.seek(event.frame * this.data.dt)));
      item.append(button);
      return item;
    });
    this.find(".events ol").replaceChildren(...items);
  }

  // The same scenario under other drivers, to be watched side by side.
  #offerOthers() {
    const [first, second] = this.entries, select = this.find("[name=beside]");
    const others = this.data.episodes.filter((entry) => entry !== first && sameScenario(entry, first));
    const options = others.map((entry) => new Option(`${entry.driver} among ${entry.pedestrians}`, this.data.episodes.indexOf(entry)));
    select.replaceChildren(new Option("nothing", ""), ...options);
    select.value = second ? String(this.data.episodes.indexOf(second)) : "";
    select.closest("label").hidden = !others.length;
  }

  // Shows what of controls and legend is only for some worlds.
  #offer(what, here) {
    for (const part of this.element.querySelectorAll(`[data-only=${what}]`)) part.hidden = !here;
  }

  #listen() {
    const actions = {
      toggle: this.toggle, back: () => this.step(-1), forward: () => this.step(1), event: () => this.nextEvent(),
      whole: () => this.#look(null),
    };
    for (const button of this.element.querySelectorAll("[data-do]")) button.addEventListener("click", actions[button.dataset.do]);
    for (const name of SWITCHES) {
      this.find(`[name=${name}]`).addEventListener("change", (event) => (this.set(name, event.target.checked), this.draw()));
    }
    this.find("[name=rate]").addEventListener("change", (event) => (this.rate = Number(event.target.value)));
    this.find(".scrub").addEventListener("input", (event) => (this.pause(), this.seek(Number(event.target.value))));
    this.find("[name=beside]").addEventListener("change", (event) => {
      const chosen = event.target.value;
      this.show([this.entries[0], ...(chosen ? [this.data.episodes[chosen]] : [])], this.time);
    });
    const strips = this.find(".strips");
    const scrub = (event) => event.buttons && (this.pause(), this.seek(this.strips.timeAt(event.offsetX, this.end)));
    strips.addEventListener("pointerdown", (event) => (strips.setPointerCapture(event.pointerId), scrub(event)));
    strips.addEventListener("pointermove", scrub);
    this.find(".link").addEventListener("click", (event) => (event.preventDefault(), this.#copyLink()));
  }

  // Stops playing when the player is hidden, and restores the page's address.
  leave() {
    this.ticket = null;
    this.pause();
    clearTimeout(this.settling);
    history.replaceState(null, "", location.pathname + location.search);
  }

  async #copyLink() {
    const link = new URL(this.link, location.href).href;
    await navigator.clipboard?.writeText(link).catch(() => {});
    this.find(".copied").textContent = navigator.clipboard ? "copied" : link;
    setTimeout(() => (this.find(".copied").textContent = ""), 3000);
  }

  // Handles a key that the page passes on; more: the page's own handlers, by key.
  key(event, more = {}) {
    if (event.ctrlKey || event.metaKey || event.altKey || !this.episodes.length) return;
    const { tagName: tag, type } = event.target;
    if (/^(SELECT|INPUT|TEXTAREA)$/.test(tag) && type !== "checkbox") return; // they have keys of their own
    if (event.key === " " && /^(BUTTON|A|SUMMARY|INPUT)$/.test(tag)) return;
    const steps = event.shiftKey ? Math.round(1 / this.data.dt) : 1;
    const actions = {
      " ": this.toggle, k: this.toggle, ArrowLeft: () => this.step(-steps), ArrowRight: () => this.step(steps), "+": () => this.faster(1),
      "-": () => this.faster(-1), Home: () => this.seek(0), End: () => this.seek(this.end), e: () => this.nextEvent(),
      ...more,
    };
    const name = KEYS[event.key];
    if (name) this.set(name, !this.shows[name]);
    else if (actions[event.key]) actions[event.key]();
    else return;
    event.preventDefault();
    this.draw();
  }
}

const sameScenario = (a, b) => a.scenario === b.scenario && a.multiplier === b.multiplier;
const ending = (about, dt) => `${{ collision: "collision", goal: "goal reached", timeout: "out of time" }[about.ending]} after ${(about.steps * dt).toFixed(1)} s`;

function moment([first, second], time) {
  const parts = { episode: first.scenario, driver: first.driver, pedestrians: first.pedestrians, t: time };
  if (second) Object.assign(parts, { beside: second.driver, among: second.pedestrians });
  return `#${new URLSearchParams(parts)}`;
}

// The entries and the time that an address such as #episode=217&t=12.3 asks for: null if it asks for none, no entries if
// they are not on this page.
function asked(data, hash) {
  const wanted = new URLSearchParams(hash.slice(1));
  if (!wanted.has("episode")) return null;
  const find = (driver, pedestrians) => data.episodes.find((entry) =>
    entry.scenario === Number(wanted.get("episode")) &&
    (!wanted.has(driver) || wanted.get(driver) === entry.driver) && (!wanted.has(pedestrians) || wanted.get(pedestrians) === entry.pedestrians));
  const entries = [find("driver", "pedestrians"), wanted.has("beside") && find("beside", "among")].filter(Boolean);
  return { entries, time: Number(wanted.get("t")) || 0 };
}

// Describes the drawing for people who can't see it.
function inWords(episode, time) {
  const { car, people } = episode.at(time);
  const when = time > episode.end ? `It ended at ${episode.end.toFixed(1)} s: the car drove` : `At ${time.toFixed(1)} s the car drives`;
  const near = people.filter((person) => person.away < 12).sort((a, b) => a.away - b.away);
  const them = near.map((person) => `pedestrian ${person.ped + 1} ${person.away.toFixed(1)} m away${person.jaywalking ? ", jaywalking" : ""}${person.unperceived ? ", not perceived by the car" : ""}`);
  return `${when} ${car.speed.toFixed(1)} m/s. Within 12 metres: ${them.join("; ") || "nobody"}.`;
}

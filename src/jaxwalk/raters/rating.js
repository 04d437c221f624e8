// Shows pairs of clips in a random order and on random sides, and keeps the answers until they are saved.

const data = JSON.parse(document.getElementById("data").textContent);
const LONGEST_FRAME = 0.1; // [s]: while the page is out of sight the films wait
const SHOWS = { hidden: true, plain: true, trails: false, follow: true };
const find = (selector) => document.querySelector(selector);
const hex = (bytes) => [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
const rater = hex(crypto.getRandomValues(new Uint8Array(8)));

// Mulberry32: the same seed gives the same order and sides. An address such as #seed=7 chooses it.
function randoms(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let mixed = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}
const given = new URLSearchParams(location.hash.slice(1)).get("seed");
const random = randoms(given === null ? crypto.getRandomValues(new Uint32Array(1))[0] : Number(given));

function shuffled(list) {
  const found = [...list];
  for (let k = found.length - 1; k > 0; k--) {
    const other = Math.floor(random() * (k + 1));
    [found[k], found[other]] = [found[other], found[k]];
  }
  return found;
}

// The rater's pairs: some of the plan's, each on a random side; checks among them, never first; the first few again at
// the end, with the sides swapped.
function order() {
  const places = data.pairs.map((_, place) => place), side = () => (random() < 0.5 ? "a" : "b");
  const rated = shuffled(places.filter((place) => !data.pairs[place].check)).slice(0, data.each);
  const shown = rated.map((pair) => ({ pair, left: side(), repeat: false }));
  const again = shown.slice(0, data.repeated).map(({ pair, left }) => ({ pair, left: left === "a" ? "b" : "a", repeat: true }));
  for (const pair of places.filter((place) => data.pairs[place].check)) {
    shown.splice(1 + Math.floor(random() * shown.length), 0, { pair, left: side(), repeat: false });
  }
  return [...shown, ...again];
}

class Film {
  constructor(canvas) {
    this.canvas = canvas;
  }

  async load(place) {
    const clip = data.clips[place];
    this.drawing = new Drawing(this.canvas, data.maps[clip.map]);
    this.episode = await Episode.load(clip, data.dt);
  }

  draw = (time) => this.drawing?.draw(this.episode, time, SHOWS);
}

class Rating {
  constructor() {
    this.shown = order();
    this.films = [...document.querySelectorAll(".clips canvas")].map((canvas) => new Film(canvas));
    this.answers = [];
    this.#listen();
  }

  async start() {
    find("#start").hidden = true;
    find("#rate").hidden = false;
    addEventListener("beforeunload", this.warn);
    await this.#next();
    requestAnimationFrame(this.#tick);
  }

  warn = (event) => event.preventDefault();

  async #next() {
    this.current = this.shown[this.answers.length];
    if (!this.current) return this.#end();
    this.ready = false;
    const pair = data.pairs[this.current.pair], sides = this.current.left === "a" ? ["a", "b"] : ["b", "a"];
    await Promise.all(this.films.map((film, k) => film.load(pair[sides[k]])));
    this.pair = pair;
    this.#allow(false);
    this.began = performance.now();
    this.time = 0;
    this.paused = false;
    this.ready = true;
    find(".at").textContent = `${this.answers.length + 1} of ${this.shown.length}`;
    find("progress").value = this.answers.length / this.shown.length;
    find("[role=status]").textContent = "Answer once you have seen both to the end.";
    find("[data-do=pause]").textContent = "Pause";
  }

  // Both films run together, and begin again at their end.
  #tick = (now) => {
    if (!this.current) return;
    if (this.ready) {
      if (!this.paused && this.before !== undefined) this.time += Math.min((now - this.before) / 1000, LONGEST_FRAME);
      if (this.time >= data.length) {
        this.time = 0;
        this.#allow(true);
      }
      for (const film of this.films) film.draw(this.pair.start + this.time);
    }
    this.before = now;
    requestAnimationFrame(this.#tick);
  };

  #allow(on) {
    for (const button of document.querySelectorAll("[data-answer]")) button.disabled = !on;
    if (on) find("[role=status]").textContent = "";
  }

  answer(choice) {
    if (!this.ready || find("[data-answer]").disabled) return;
    this.answers.push({ ...this.current, answer: choice, seconds: Math.round((performance.now() - this.began) / 100) / 10 });
    this.#next();
  }

  pause() {
    this.paused = !this.paused;
    find("[data-do=pause]").textContent = this.paused ? "Play" : "Pause";
  }

  #end() {
    const file = { schema: data.schema, plan: data.plan, rater, adult: true, consent: true, answers: this.answers };
    const link = find("a.save");
    link.href = URL.createObjectURL(new Blob([JSON.stringify(file)], { type: "application/json" }));
    link.download = `answers-${rater}.json`;
    link.addEventListener("click", () => removeEventListener("beforeunload", this.warn));
    find(".rater").textContent = rater;
    find("#rate").hidden = true;
    find("#end").hidden = false;
  }

  #listen() {
    for (const button of document.querySelectorAll("[data-answer]")) button.addEventListener("click", () => this.answer(button.dataset.answer));
    find("[data-do=pause]").addEventListener("click", () => this.pause());
    find("[data-do=again]").addEventListener("click", () => (this.time = 0));
    addEventListener("keydown", (event) => {
      if (find("#rate").hidden || event.ctrlKey || event.metaKey || event.altKey) return;
      const choice = { 1: "left", 2: "equal", 3: "right" }[event.key];
      if (choice) this.answer(choice);
      else if (event.key === " " && event.target.tagName !== "BUTTON") event.preventDefault(), this.pause();
    });
  }
}

const rating = (window.rating = new Rating());
const boxes = [...document.querySelectorAll(".agree input")], begin = find("[data-do=start]");
for (const box of boxes) box.addEventListener("change", () => (begin.disabled = !boxes.every((one) => one.checked)));
begin.addEventListener("click", () => rating.start());

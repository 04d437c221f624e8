// Plays what the server of jaxwalk.live sends, and sends what a person chooses and how they drive.

const DIALS = ["people", "jaywalk_multiplier", "max_speed", "parked"];
const LATE = 3; // steps that the drawing may be behind what was received
const SHOWN = 20; // seconds that the strips show at least
const PATIENCE = 400; // milliseconds before it is said that something takes time

// A word for a shell.
const quoted = (word) => (/^[\w./:+-]+$/.test(word) ? word : `'${word.replaceAll("'", `'\\''`)}'`);

class Live {
  constructor(element, address) {
    this.element = element;
    this.find = (selector) => element.querySelector(selector);
    this.form = this.find("form");
    this.strips = new Strips(this.find(".strips"));
    this.wheel = new Wheel(element, (message) => this.tell(message), () => this.choice && this.#caption());
    this.shows = {};
    this.time = 0;
    this.playing = false;
    this.wanted = this.asked = null;
    this.#listen();
    this.socket = new WebSocket(address);
    this.socket.addEventListener("message", (event) => this.#hear(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => this.#closed());
    new ResizeObserver(() => this.draw()).observe(element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  #hear({ kind, ...said }) {
    ({
      offer: () => this.#offer(said), begin: () => this.#begin(said), frame: () => this.#frame(said),
      busy: () => (this.waiting = setTimeout(() => this.say("Preparing: what is new in this choice is compiled, once. It may take a minute …"), PATIENCE)),
      playing: () => this.#showPlaying(said.playing),
      saved: () => this.#saved(said.path),
      problem: () => this.#problem(said.text),
    })[kind]();
  }

  tell = (message) => this.socket.readyState === WebSocket.OPEN && this.socket.send(JSON.stringify(message));

  say(text, problem = false) {
    const line = this.find(".said");
    line.classList.toggle("problem", problem);
    line.textContent = text;
  }

  #offer({ streets, worlds, drivers, pedestrians, places, kept }) {
    this.suits = streets;
    const lists = { street: Object.keys(streets), world: worlds, driver: drivers, pedestrians, places };
    for (const [name, values] of Object.entries(lists)) {
      this.form.elements[name].replaceChildren(...values.map((value) => new Option(value, value)));
    }
    this.kept = kept !== null;
    if (this.kept) this.form.elements.number.max = kept - 1;
    for (const part of this.form.querySelectorAll("[data-drawn]")) part.hidden = this.kept;
  }

  #begin({ choice, record, dt, map, frame, hides, most }) {
    this.#answered();
    const same = this.episode && JSON.stringify(map) === this.drawn;
    const canvas = this.find(".stage canvas");
    this.drawn = JSON.stringify(map);
    if (!same) {
      this.drawing = new Drawing(canvas, map);
      this.touch ??= new Touch(canvas, this.drawing, (view) => this.#look(view));
      this.touch.drawing = this.drawing;
    }
    this.choice = choice;
    this.dt = dt;
    this.episode = new GrowingEpisode(record, dt);
    this.episode.grow(frame);
    this.time = 0;
    this.#fill(hides, most);
    for (const part of this.element.querySelectorAll("[data-only=sight]")) part.hidden = record.delay === undefined;
    for (const button of this.element.querySelectorAll("button")) button.disabled = false;
    this.#caption();
    this.say(this.playing ? "Playing" : "Ready: press Play, or an arrow key to drive yourself");
    this.draw();
    this.#send();
  }

  // What was asked for is there, or can't be; the next wish can be sent.
  #answered() {
    clearTimeout(this.waiting);
    this.asked = null;
  }

  // A dial reaches as far as any value that it was to show, so that it shows each as it is.
  #fill(hides, most = this.form.elements.people.max) {
    const { elements } = this.form;
    elements.people.max = most;
    elements.parked.disabled = !hides;
    for (const { dial, value } of DIALS.slice(1).map((name) => ({ dial: elements[name], value: this.choice[name] }))) {
      if (value === null) continue;
      dial.min = Math.min(dial.min, value);
      dial.max = Math.max(dial.max, value);
    }
    for (const name of Object.keys(this.choice)) if (this.choice[name] !== null) elements[name].value = this.choice[name];
    this.#sayDials(hides);
  }

  // Says each dial's exact number; of one that is being turned, where it stands.
  #sayDials(hides = !this.form.elements.parked.disabled, turned = null) {
    const { elements } = this.form, exact = (name) => (name === turned ? null : this.choice?.[name]);
    const value = (name) => exact(name) ?? Number(elements[name].value);
    const said = {
      people: `${value("people")} of ${elements.people.max}`,
      jaywalk_multiplier: value("jaywalk_multiplier").toFixed(2),
      max_speed: `${Math.round(value("max_speed") * 3.6)} km/h`,
      parked: hides ? `${Math.round(value("parked") * 100)} %` : "none here",
    };
    for (const name of DIALS) elements[`${name}-said`].value = said[name];
  }

  #frame(frame) {
    this.episode.grow(frame);
    if (!this.playing) this.time = this.episode.end;
    if (frame.ending) this.#ended(frame);
    this.#animate();
  }

  #ended({ ending, touched }) {
    const { end, car } = this.episode, speed = Math.round(car.speed.at(-1) * 3.6);
    const who = touched.map((ped) => ped + 1).join(" and ");
    this.say({
      goal: `The car reached its goal after ${end.toFixed(1)} s.`,
      collision: `Collision with pedestrian ${who} after ${end.toFixed(1)} s, at ${speed} km/h.`,
      timeout: `Out of time after ${end.toFixed(1)} s.`,
    }[ending]);
  }

  #problem(text) {
    this.#answered();
    this.say(text, true);
    this.wanted = null;
    if (this.choice) this.#fill(!this.form.elements.parked.disabled);
  }

  #closed() {
    this.#answered();
    this.#showPlaying(false);
    for (const button of this.element.querySelectorAll("button")) button.disabled = true;
    this.say("The server has ended. Start jaxwalk live again, and reload this page.", true);
  }

  #saved(path) {
    const line = this.find(".saved"), command = document.createElement("code");
    const [file, driver, people] = [path, this.choice.driver, this.choice.pedestrians].map(quoted);
    command.textContent = `jaxwalk play --scenarios ${file} --driver ${driver} --pedestrians ${people} --html`;
    line.replaceChildren(`Saved as ${path}. To play it again: `, command);
  }

  #showPlaying(playing) {
    this.playing = playing;
    this.find("[data-do=toggle]").textContent = playing ? "❚❚ Pause" : "▶ Play";
    if (playing) this.say("Playing");
    else if (this.episode && this.episode.last >= 0) {
      this.time = this.episode.end;
      if (!this.episode.events.length) this.say("Paused");
      this.find(".stage canvas").setAttribute("aria-label", inWords(this.episode, this.time));
    }
    this.#animate();
  }

  #caption() {
    const { driver, pedestrians, number, seed } = this.choice;
    const who = this.wheel.drives ? "You drive" : `${driver} drives`;
    this.find("figcaption").textContent = `${who} among ${pedestrians}, scenario ${number} of ${this.kept ? "the file" : `seed ${seed}`}`;
  }

  // The drawing follows what was received, a step behind, so that it moves evenly.
  #animate() {
    cancelAnimationFrame(this.next);
    if (!this.episode) return;
    let before = performance.now();
    const tick = (now) => {
      const { end } = this.episode, wanted = this.time + ((now - before) / 1000) * this.rate;
      before = now;
      this.time = Math.min(Math.max(wanted, end - LATE * this.dt), end);
      this.draw();
      if (this.playing || this.time < end) this.next = requestAnimationFrame(tick);
    };
    this.next = requestAnimationFrame(tick);
  }

  draw() {
    const { episode, time } = this;
    if (!episode) return;
    const { car } = this.drawing.draw(episode, time, this.shows);
    this.strips.draw([episode], time, Math.max(SHOWN, Math.ceil(time / 10) * 10));
    this.find(".clock").textContent = `${time.toFixed(1)} s, ${Math.round(car.speed * 3.6)} km/h`;
  }

  #look(view) {
    this.#show("follow", false);
    this.drawing.view = view;
    this.draw();
  }

  #show(name, on) {
    this.shows[name] = on;
    this.find(`[name=${name}]`).checked = on;
    if (name === "follow" && this.drawing) this.drawing.view = null;
  }

  get rate() {
    return Number(this.find("[name=rate]").value);
  }

  toggle() {
    if (this.playing) this.tell({ do: "pause" });
    else {
      if (this.episode.events.length) this.again();
      this.tell({ do: "play", rate: this.rate });
    }
  }

  again = () => this.#want(this.#latest);

  // Asks for a choice; while one is being opened, only the last wish is kept.
  #want(choice) {
    this.wanted = choice;
    this.#send();
  }

  #send() {
    if (this.asked || !this.wanted) return;
    this.asked = this.wanted;
    this.wanted = null;
    this.tell({ do: "open", choice: this.asked });
  }

  // Reads the form, of which a field was changed. Another street, world or room has the dials of its own.
  #changed(name) {
    const { elements } = this.form;
    if (!this.form.reportValidity()) return;
    if (name === "street") elements.world.value = this.suits[elements.street.value];
    const choice = { ...this.#latest };
    for (const field of ["street", "world", "driver", "pedestrians"]) choice[field] = elements[field].value;
    for (const field of ["places", "seed", "number"]) choice[field] = Number(elements[field].value);
    if (DIALS.includes(name)) choice[name] = Math.round(Number(elements[name].value) * 100) / 100; // others keep their exact number
    if (["street", "world", "places", "usual"].includes(name)) for (const dial of DIALS) choice[dial] = null;
    if (name === "number" && this.kept) choice.people = null; // each scenario of a file has its own people
    this.#want(choice);
  }

  // What was asked for last.
  get #latest() {
    return this.wanted ?? this.asked ?? this.choice;
  }

  #listen() {
    const actions = {
      toggle: () => this.toggle(), step: () => this.tell({ do: "step" }), again: this.again,
      next: () => this.#next(), drive: () => this.wheel.drive(!this.wheel.drives), usual: () => this.#changed("usual"),
      save: () => this.tell({ do: "save" }),
    };
    for (const button of this.element.querySelectorAll("[data-do]")) button.addEventListener("click", () => actions[button.dataset.do]());
    for (const name of SWITCHES) {
      this.#show(name, this.find(`[name=${name}]`).checked);
      this.find(`[name=${name}]`).addEventListener("change", (event) => (this.#show(name, event.target.checked), this.draw()));
    }
    this.find("[name=rate]").addEventListener("change", () => this.playing && this.tell({ do: "play", rate: this.rate }));
    this.form.addEventListener("input", ({ target }) => this.#sayDials(undefined, target.name));
    this.#leaveWhatWasPointedAt();
    this.form.addEventListener("change", (event) => this.#changed(event.target.name));
    this.form.addEventListener("submit", (event) => event.preventDefault());
    document.addEventListener("keydown", (event) => this.#key(event, actions));
  }

  // Arrow keys turn the dial that has the focus. Who got there with Tab wants that; who used a pointer wants to drive
  // with the next ones.
  #leaveWhatWasPointedAt() {
    let pointed = false;
    const leave = ({ target }) => pointed && target.matches("select, [type=range]") && target.blur();
    this.element.addEventListener("pointerdown", () => (pointed = true));
    this.element.addEventListener("keydown", () => (pointed = false));
    this.element.addEventListener("change", leave);
    this.element.addEventListener("click", (event) => event.target.type === "range" && leave(event));
  }

  #next() {
    const { number } = this.form.elements;
    number.value = (Number(number.value) + 1) % (Number(number.max) + 1);
    this.#changed("number");
  }

  #key(event, actions) {
    if (event.ctrlKey || event.metaKey || event.altKey || !this.episode) return;
    const { tagName: tag, type } = event.target, key = letter(event);
    if (/^(SELECT|INPUT|TEXTAREA)$/.test(tag) && type !== "checkbox") return; // they have keys of their own
    if (key === " " && /^(BUTTON|A|SUMMARY|INPUT)$/.test(tag)) return;
    const named = { " ": "toggle", ".": "step", r: "again", n: "next", t: "drive" }[key];
    if (HELD[key]) this.wheel.hold(HELD[key], true);
    else if (named) actions[named]();
    else return;
    event.preventDefault();
  }
}

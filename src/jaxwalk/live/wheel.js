// Pedals and wheel: the keys and buttons that a person holds down, and who drives.

const HELD = {
  ArrowUp: "throttle", w: "throttle", ArrowDown: "brake", s: "brake", ArrowLeft: "left", a: "left", ArrowRight: "right", d: "right",
};
const STEERING = 0.4; // share of the largest steering angle while a key is held

class Wheel {
  // element: has the buttons; tell: called with each message to the server; changed: called when somebody else drives.
  constructor(element, tell, changed) {
    this.buttons = element.querySelectorAll("[data-hold]");
    this.toggle = element.querySelector("[data-do=drive]");
    this.tell = tell;
    this.changed = changed;
    this.held = new Set();
    this.drives = false;
    for (const button of this.buttons) {
      const name = button.dataset.hold;
      button.addEventListener("pointerdown", (event) => (button.setPointerCapture(event.pointerId), this.hold(name, true)));
      for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => this.hold(name, false));
    }
    addEventListener("blur", () => this.release());
    document.addEventListener("keyup", (event) => this.hold(HELD[letter(event)], false));
  }

  drive(drives) {
    this.drives = drives;
    this.toggle.setAttribute("aria-pressed", drives);
    this.toggle.textContent = drives ? "Give the car back" : "Drive yourself";
    this.changed();
    this.#say();
  }

  // Presses or releases a pedal or the wheel; a press takes over from the driver.
  hold(name, on) {
    if (!name || this.held.has(name) === on) return;
    if (on) this.held.add(name);
    else this.held.delete(name);
    if (on && !this.drives) this.drive(true);
    else this.#say();
  }

  release() {
    if (!this.held.size) return;
    this.held.clear();
    this.#say();
  }

  #say() {
    for (const button of this.buttons) button.classList.toggle("held", this.held.has(button.dataset.hold));
    const [throttle, brake, left, right] = ["throttle", "brake", "left", "right"].map((name) => this.held.has(name));
    this.tell({ do: "hand", drives: this.drives, pedal: brake ? -1 : throttle ? 1 : 0, steering: left === right ? null : left ? STEERING : -STEERING });
  }
}

// The key of an event; a letter in lower case.
const letter = ({ key }) => (key.length === 1 ? key.toLowerCase() : key);

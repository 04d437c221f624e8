// Moving a drawing by hand: drag, wheel with Ctrl (without, the page scrolls), two fingers; a double click shows all of the
// map.

class Touch {
  // look: called with the new view { x, y, zoom }; null shows the whole map.
  constructor(canvas, drawing, look) {
    this.canvas = canvas;
    this.drawing = drawing;
    this.look = look;
    this.fingers = new Map();
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("dblclick", () => look(null));
  }

  #down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  }

  #move(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const others = [...this.fingers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const now = [event.offsetX, event.offsetY];
    this.fingers.set(event.pointerId, now);
    if (others.length) this.#zoom(distance(now, others[0]) / Math.max(distance(before, others[0]), 1), others[0]);
    else this.#drag(now[0] - before[0], now[1] - before[1]);
  }

  #wheel(event) {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    this.#zoom(Math.exp(-event.deltaY / 400), [event.offsetX, event.offsetY]);
  }

  #drag(dx, dy) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { scale, fit } = this.drawing;
    this.look({ ...this.drawing.toMetres(width / 2 - dx, height / 2 - dy), zoom: scale / fit });
  }

  // The point of the map under [px, py] stays there.
  #zoom(factor, [px, py]) {
    const { clientWidth: width, clientHeight: height } = this.canvas, { scale, fit } = this.drawing;
    const zoom = Math.min(Math.max((scale / fit) * factor, 1), 20), kept = this.drawing.toMetres(px, py);
    this.look({ x: kept.x - (px - width / 2) / (fit * zoom), y: kept.y + (py - height / 2) / (fit * zoom), zoom });
  }
}

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

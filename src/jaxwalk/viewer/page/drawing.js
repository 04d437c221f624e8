// Draws a map and everything that moves on it on a canvas. Units are metres, y to the north; a pixel is a CSS pixel.

const CAR = [[-2.25, -0.9], [1.8, -0.9], [2.25, 0], [1.8, 0.9], [-2.25, 0.9]]; // a rectangle with a pointed front
const RINGS = [3, 6, 9, 12]; // [m]
const CLOSE = 44; // metres shown while following the car
const SEAM = 0.6; // overlap of surfaces in pixels; without it, the ground shows between them
const SURFACES = ["building", "sidewalk", "roadway", "parking", "island", "raised"]; // each covers those before it
const TRAIL = 3; // length of a pedestrian's trail [s]
const NEAREST = 6; // pedestrians that the car observes individually
const PALE = 0.3, FAINTEST = 0.15; // opacity of who isn't perceived, and the lowest of where somebody was last seen
// From pale to dark: the colours differ in lightness, which colour-blind people see too.
const TENDENCY = [[255, 244, 214], [245, 178, 66], [205, 84, 10], [84, 20, 8]];

function tendencyColour(tau) {
  const place = Math.min(Math.max(tau, 0), 1) * (TENDENCY.length - 1);
  const k = Math.min(Math.floor(place), TENDENCY.length - 2);
  return `rgb(${TENDENCY[k].map((low, i) => Math.round(low + (TENDENCY[k + 1][i] - low) * (place - k)))})`;
}

class Drawing {
  constructor(canvas, map) {
    this.canvas = canvas;
    this.map = map;
    this.surfaces = SURFACES.map((kind) => [kind, outlines(map.surfaces[kind], true)]);
    this.stripes = outlines(map.stripes, true);
    this.lines = [[outlines(map.dashed), [1.5, 1.5]], [outlines(map.dotted), [0.3, 0.6]]];
    this.view = null; // { x, y, zoom }: moved by hand; null: all of the map
  }

  // Fits the canvas to its element, and scales it to metres.
  #begin(centre) {
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const fit = Math.min(width / this.map.width, height / this.map.height);
    this.fit = fit;
    this.scale = this.view ? fit * this.view.zoom : centre ? Math.min(width, height) / CLOSE : fit;
    const middle = centre ?? this.view ?? { x: this.map.width / 2, y: this.map.height / 2 };
    this.left = width / 2 - middle.x * this.scale;
    this.top = height / 2 + middle.y * this.scale;
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.colour = palette(this.canvas);
    context.fillStyle = this.colour.block;
    context.fillRect(0, 0, width, height);
    return context;
  }

  toPixels = (x, y) => [this.left + x * this.scale, this.top - y * this.scale];
  toMetres = (px, py) => ({ x: (px - this.left) / this.scale, y: (this.top - py) / this.scale });

  // shows: { hidden, sight, plans, rings, follow, trails, plain } switches. Without hidden, who isn't perceived isn't drawn.
  // plain: everybody is the same disc, whatever they intend.
  draw(episode, time, shows) {
    const now = episode.at(time);
    this.plain = shows.plain;
    const c = this.#begin(shows.follow ? now.car : null);
    this.#ground(c);
    if (episode.parked) this.#parked(c, episode);
    if (shows.plans) this.#route(c, episode);
    this.#goal(c, episode.goal);
    if (shows.trails) this.#trails(c, episode, now, shows.hidden);
    if (shows.plans && shows.hidden) this.#plans(c, episode, now);
    if (shows.rings) this.#rings(c, now.car);
    this.#car(c, now.car);
    const drawn = now.people.filter((person) => shows.hidden || !person.unperceived);
    if (shows.sight) for (const person of now.people) if (person.lastSeen) this.#lastSeen(c, person);
    for (const person of drawn) this.#person(c, person, shows.hidden, shows.sight && person.unperceived);
    if (now.over && episode.touched.size) this.#crash(c, now, episode);
    this.#attribution(c);
    return now;
  }

  // Whose data the street was made from.
  #attribution(c) {
    if (!this.map.attribution) return;
    c.font = "10px sans-serif";
    c.textAlign = "right";
    c.textBaseline = "bottom";
    const x = this.canvas.clientWidth - 3, y = this.canvas.clientHeight - 2;
    c.fillStyle = this.colour.block;
    c.globalAlpha = 0.7;
    c.fillRect(x - c.measureText(this.map.attribution).width - 2, y - 12, this.canvas.clientWidth, 14);
    c.globalAlpha = 1;
    c.fillStyle = this.colour.ink;
    c.fillText(this.map.attribution, x, y);
    c.textAlign = "start";
    c.textBaseline = "alphabetic";
  }

  #ground(c) {
    c.save();
    c.transform(this.scale, 0, 0, -this.scale, this.left, this.top); // metres
    c.lineWidth = SEAM / this.scale;
    for (const [kind, shape] of this.surfaces) {
      c.fillStyle = c.strokeStyle = this.colour[kind];
      c.fill(shape);
      c.stroke(shape);
    }
    c.fillStyle = c.strokeStyle = this.colour.paint;
    c.fill(this.stripes);
    c.lineWidth = 1 / this.scale;
    for (const [shape, dash] of this.lines) {
      c.setLineDash(dash);
      c.stroke(shape);
    }
    c.restore();
  }

  #parked(c, episode) {
    episode.parkedShape ??= outlines(episode.parked, true);
    c.save();
    c.transform(this.scale, 0, 0, -this.scale, this.left, this.top); // metres
    c.lineWidth = 1.2 / this.scale;
    c.fillStyle = this.colour.parked;
    c.strokeStyle = this.colour.halo;
    c.fill(episode.parkedShape);
    c.stroke(episode.parkedShape);
    c.restore();
  }

  #path(c, xs, ys, first = 0, last = xs.length - 1) {
    c.beginPath();
    for (let k = first; k <= last; k++) c.lineTo(...this.toPixels(xs[k], ys[k]));
  }

  #stroke(c, colour, width, dash = []) {
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.lineCap = c.lineJoin = "round";
    c.stroke();
    c.setLineDash([]);
  }

  #route(c, episode) {
    if (!episode.route) return;
    this.#path(c, episode.route.x, episode.route.y);
    this.#stroke(c, this.colour.route, 2.5, [2, 7]);
  }

  #goal(c, [x, y]) {
    const [px, py] = this.toPixels(x, y);
    for (const [colour, width] of [[this.colour.halo, 7], [this.colour.goal, 3.5]]) {
      c.beginPath();
      c.moveTo(px - 7, py - 7); c.lineTo(px + 7, py + 7);
      c.moveTo(px - 7, py + 7); c.lineTo(px + 7, py - 7);
      this.#stroke(c, colour, width);
    }
  }

  #trails(c, episode, now, hidden) {
    this.#path(c, episode.car.x, episode.car.y, 0, now.frame);
    this.#stroke(c, this.colour.car, 2);
    const first = Math.max(0, now.frame - Math.round(TRAIL / episode.dt));
    for (const [ped, one] of episode.people.entries()) {
      const { since, unperceived } = now.people[ped];
      if (unperceived && !hidden) continue;
      this.#path(c, one.x, one.y, hidden ? first : Math.max(first, since), now.frame);
      this.#stroke(c, hidden ? tendencyColour(episode.tendency[ped]) : this.colour.person, 2);
    }
  }

  // Draws the rest of everybody's way to the goal, with jaywalks in their own colour.
  #plans(c, episode, now) {
    for (const [ped, plan] of (episode.plans ?? []).entries()) {
      const person = now.people[ped], leg = plan.leg[now.frame];
      const until = plan.goals.find((goal) => goal > leg) ?? plan.x.length - 1;
      for (let k = leg; k < until; k++) {
        c.beginPath();
        c.moveTo(...(k === leg ? this.toPixels(person.x, person.y) : this.toPixels(plan.x[k], plan.y[k])));
        c.lineTo(...this.toPixels(plan.x[k + 1], plan.y[k + 1]));
        const jaywalk = plan.jaywalks.has(k);
        this.#stroke(c, jaywalk ? this.colour.jaywalk : this.colour.plan, jaywalk ? 3 : 1.5, jaywalk ? [] : [1, 5]);
      }
    }
  }

  #rings(c, car) {
    const [px, py] = this.toPixels(car.x, car.y);
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "center";
    for (const ring of RINGS) {
      c.beginPath();
      c.arc(px, py, ring * this.scale, 0, 2 * Math.PI);
      this.#stroke(c, this.colour.ring, 1);
      this.#text(c, `${ring} m`, px, py - ring * this.scale - 3);
    }
  }

  #text(c, text, x, y) {
    c.lineWidth = 3;
    c.strokeStyle = this.colour.halo;
    c.strokeText(text, x, y);
    c.fillStyle = this.colour.ink;
    c.fillText(text, x, y);
  }

  #car(c, car) {
    const cos = Math.cos(car.heading), sin = Math.sin(car.heading);
    c.beginPath();
    for (const [ahead, left] of CAR) c.lineTo(...this.toPixels(car.x + cos * ahead - sin * left, car.y + sin * ahead + cos * left));
    c.closePath();
    c.fillStyle = this.colour.car;
    c.fill();
    this.#stroke(c, this.colour.halo, 1.5);
    if (car.command < -0.5) { // brake lights
      for (const side of [-0.6, 0.6]) {
        const [px, py] = this.toPixels(car.x - 2.1 * cos - side * sin, car.y - 2.1 * sin + side * cos);
        c.beginPath();
        c.arc(px, py, Math.max(2, 0.35 * this.scale), 0, 2 * Math.PI);
        c.fillStyle = this.colour.brake;
        c.fill();
      }
    }
  }

  // Draws a disc for walking, a diamond for jaywalking, a square for waiting: the shapes need no colour.
  // One that the car doesn't perceive is pale, with a dashed outline.
  #person(c, person, hidden, pale) {
    const [px, py] = this.toPixels(person.x, person.y), size = Math.max(5, 0.55 * this.scale);
    const seen = hidden || this.plain || person.rank < NEAREST;
    c.beginPath();
    if (this.plain) hidden = false;
    if (hidden && person.jaywalking) for (const [dx, dy] of [[0, 1.5], [1.5, 0], [0, -1.5], [-1.5, 0]]) c.lineTo(px + dx * size, py + dy * size);
    else if (hidden && person.waiting) c.rect(px - size, py - size, 2 * size, 2 * size);
    else c.arc(px, py, size, 0, 2 * Math.PI);
    c.closePath();
    c.fillStyle = hidden ? tendencyColour(person.tendency) : seen ? this.colour.person : this.colour.block;
    if (pale) c.globalAlpha = PALE;
    c.fill();
    c.globalAlpha = 1;
    const jaywalks = hidden && person.jaywalking;
    this.#stroke(c, jaywalks ? this.colour.jaywalk : this.colour.edge, jaywalks ? 2.5 : 1.2, pale ? [3, 3] : []);
    if (this.plain) return;
    if (!hidden && seen) this.#velocity(c, person, px, py);
    if (this.scale < 9) return;
    c.font = `${Math.round(size * 1.3)}px system-ui, sans-serif`;
    c.textAlign = "center";
    c.fillStyle = hidden && person.tendency < 0.6 ? "#1c1c1c" : hidden ? "#fff" : seen ? this.colour.halo : this.colour.ink;
    c.fillText(String(person.ped + 1), px, py + size * 0.45);
  }

  // Draws where the car last saw somebody: a dashed ring that fades with age.
  #lastSeen(c, { ped, lastSeen: { x, y, age } }) {
    const [px, py] = this.toPixels(x, y), size = Math.max(6, 0.65 * this.scale);
    c.globalAlpha = Math.max(FAINTEST, 1 - age / KEPT);
    for (const [colour, width, dash] of [[this.colour.halo, 4, []], [this.colour.seen, 2.5, [4, 4]]]) {
      c.beginPath();
      c.arc(px, py, size, 0, 2 * Math.PI);
      this.#stroke(c, colour, width, dash);
    }
    if (this.scale >= 9) {
      c.font = `${Math.round(size)}px system-ui, sans-serif`;
      c.textAlign = "center";
      this.#text(c, String(ped + 1), px, py + size * 0.35);
    }
    c.globalAlpha = 1;
  }

  // Draws where a pedestrian will be in a second at this velocity, which is all that the car knows about its plans.
  #velocity(c, person, px, py) {
    c.beginPath();
    c.moveTo(px, py);
    c.lineTo(...this.toPixels(person.x + person.vx, person.y + person.vy));
    this.#stroke(c, this.colour.ink, 2);
  }

  #crash(c, now, episode) {
    for (const ped of episode.touched) {
      const [px, py] = this.toPixels((now.people[ped].x + now.car.x) / 2, (now.people[ped].y + now.car.y) / 2);
      for (const [colour, width] of [[this.colour.halo, 7], [this.colour.goal, 3.5]]) {
        c.beginPath();
        c.arc(px, py, Math.max(20, 2.2 * this.scale), 0, 2 * Math.PI);
        this.#stroke(c, colour, width);
      }
    }
  }
}

// One path in metres of outlines (x, y, x, y ...), or of lines.
function outlines(each, closed = false) {
  const path = new Path2D();
  for (const points of each) {
    path.moveTo(points[0], points[1]);
    for (let k = 2; k < points.length; k += 2) path.lineTo(points[k], points[k + 1]);
    if (closed) path.closePath();
  }
  return path;
}

const NAMES = ["block", ...SURFACES, "paint", "parked", "seen", "car", "route", "goal", "brake", "person", "plan", "jaywalk", "ring", "edge", "halo", "ink", "grid"];

// The page's colours, which follow light and dark.
function palette(element) {
  const style = getComputedStyle(element);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

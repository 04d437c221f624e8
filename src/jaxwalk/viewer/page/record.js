// Unpacks the episodes of jaxwalk.viewer.record, and returns what they show at any time.

const GOING = 1, ON_ROADWAY = 2, JAYWALKS = 4, UNPERCEIVED = 8;
const KEPT = 3; // who is lost from sight is remembered for this long [s]
const METRE = 100, RADIAN = 1000;

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(stream).text());
}

// Differences back to values.
function values(differences, perUnit = 1) {
  let total = 0;
  return Float64Array.from(differences, (difference) => (total += difference) / perUnit);
}

const points = (line) => ({ x: values(line.x, METRE), y: values(line.y, METRE) });
const between = (array, k, share) => array[k] + (array[Math.min(k + 1, array.length - 1)] - array[k]) * share;

class Episode {
  // about: the entry of the page's list (scenario, driver, pedestrians, ending, map); record: the unpacked record.
  constructor(about, record, dt) {
    this.about = about;
    this.dt = dt;
    this.goal = record.goal;
    this.touched = new Set(record.touched);
    this.tendency = record.tendency;
    this.events = record.events;
    const car = record.car;
    this.car = {
      ...points(car), heading: values(car.heading, RADIAN),
      speed: values(car.speed, METRE), command: values(car.acceleration, METRE),
    };
    this.car.acceleration = this.car.speed.map((speed, k, all) => (k ? (speed - all[k - 1]) / dt : 0));
    this.delay = record.delay; // steps; missing in a world without perception
    this.parked = record.parked && corners(record.parked);
    this.people = record.people.map((one) => ({
      ...points(one), state: values(one.state), lost: one.lost && points(one.lost), ...sights(values(one.state)),
    }));
    this.route = record.route && points(record.route);
    this.plans = record.paths?.map((plan) => ({ ...points(plan), jaywalks: new Set(plan.jaywalks), goals: plan.goals }));
    this.plans?.forEach((plan, ped) => (plan.leg = this.#legs(plan, this.people[ped])));
    this.last = this.car.x.length - 1;
    this.end = this.last * dt;
  }

  static async load(about, dt) {
    return new Episode(about, await inflate(about.record), dt);
  }

  // The leg of the path that a pedestrian is on in each frame: the first one from the last frame's leg on that passes
  // there and isn't finished (after turning round, a pedestrian passes the same place again).
  #legs(plan, person) {
    const ends = lengths(plan), walked = lengths(person);
    let leg = 0;
    return person.x.map((_, k) => {
      const left = (candidate) => ends[candidate + 1] < walked[k] - 0.02 || distanceToLeg(plan, candidate, person.x[k], person.y[k]) > 0.1;
      let candidate = leg;
      while (candidate < plan.x.length - 1 && left(candidate)) candidate++;
      if (candidate < plan.x.length - 1) leg = candidate;
      return leg;
    });
  }

  // Returns everything at a time [s], interpolated linearly between frames.
  at(time) {
    const exact = Math.min(Math.max(time / this.dt, 0), this.last);
    const frame = Math.floor(exact), share = exact - frame;
    const car = Object.fromEntries(Object.entries(this.car).map(([name, array]) => [name, between(array, frame, share)]));
    // A command and its effect belong to the step that leads to their frame.
    for (const name of ["command", "acceleration"]) car[name] = this.car[name][Math.min(Math.ceil(exact), this.last)];
    const people = this.people.map((one, ped) => this.#person(one, ped, frame, share, car));
    [...people].sort((a, b) => a.unperceived - b.unperceived || a.away - b.away).forEach((person, rank) => (person.rank = rank));
    return { frame, car, people, over: exact > this.last - 1e-6 };
  }

  #person(one, ped, frame, share, car) {
    const x = between(one.x, frame, share), y = between(one.y, frame, share);
    const before = Math.max(frame - 1, 0), state = one.state[frame];
    const moves = state & GOING && frame > 0;
    return {
      ped, x, y, state, away: Math.hypot(x - car.x, y - car.y), tendency: this.tendency[ped],
      vx: moves ? (one.x[frame] - one.x[before]) / this.dt : 0,
      vy: moves ? (one.y[frame] - one.y[before]) / this.dt : 0,
      jaywalking: (state & ON_ROADWAY) > 0 && (state & JAYWALKS) > 0,
      waiting: !(state & GOING) && frame > 0,
      unperceived: (state & UNPERCEIVED) > 0, since: one.since[frame], lastSeen: this.#lastSeen(one, frame, share),
    };
  }

  // Where the car last saw somebody lost from sight, and how old that is [s]; null if it sees them, or has forgotten them.
  #lastSeen(one, frame, share) {
    const which = one.losses[frame] - 1;
    if (!(one.state[frame] & UNPERCEIVED) || which < 0) return null;
    const age = (frame + share - one.since[frame] + this.delay + 1) * this.dt;
    return age <= KEPT + 1e-6 ? { x: one.lost.x[which], y: one.lost.y[which], age } : null;
  }
}

// For each frame: since which one somebody is perceived, or not, without a break; and how often the car has lost them.
function sights(states) {
  let from = 0, count = 0;
  const since = [], losses = [];
  for (const [k, state] of states.entries()) {
    if (k && (state ^ states[k - 1]) & UNPERCEIVED) {
      from = k;
      if (state & UNPERCEIVED) count++;
    }
    since.push(from);
    losses.push(count);
  }
  return { since, losses };
}

// Outlines (x, y, x, y ...) of parked vehicles.
function corners(boxes) {
  const { x, y } = points(boxes), heading = values(boxes.heading, RADIAN);
  const length = values(boxes.length, METRE), width = values(boxes.width, METRE);
  return [...x].map((_, k) => {
    const cos = Math.cos(heading[k]), sin = Math.sin(heading[k]), ahead = length[k] / 2, left = width[k] / 2;
    const places = [[ahead, -left], [ahead, left], [-ahead, left], [-ahead, -left]];
    return places.flatMap(([a, b]) => [x[k] + cos * a - sin * b, y[k] + sin * a + cos * b]);
  });
}

// Metres along a line up to each of its points.
function lengths({ x, y }) {
  let total = 0;
  return x.map((here, k) => (total += k ? Math.hypot(here - x[k - 1], y[k] - y[k - 1]) : 0));
}

function distanceToLeg(line, leg, x, y) {
  const ax = line.x[leg], ay = line.y[leg], dx = line.x[leg + 1] - ax, dy = line.y[leg + 1] - ay;
  const squared = dx * dx + dy * dy;
  const share = squared > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / squared, 0), 1) : 0;
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

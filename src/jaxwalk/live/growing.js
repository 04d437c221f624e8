// An episode of which only the start is known, and which grows frame by frame.
class GrowingEpisode extends Episode {
  constructor(record, dt) {
    super({}, record, dt);
    for (const name of Object.keys(this.car)) this.car[name] = [];
    for (const one of this.people) Object.assign(one, { x: [], y: [], state: [], lost: { x: [], y: [] } });
  }

  grow({ car: [x, y, heading, speed, command], people, ending, touched }) {
    const { car } = this, before = this.last;
    const turned = before < 0 ? 0 : Math.round((car.heading[before] - heading) / (2 * Math.PI)) * 2 * Math.PI;
    const acceleration = before < 0 ? 0 : (speed - car.speed[before]) / this.dt;
    Object.entries({ x, y, heading: heading + turned, speed, command, acceleration }).forEach(([name, value]) => car[name].push(value));
    for (const [ped, [px, py, state, lostX, lostY]] of people.entries()) {
      const one = this.people[ped];
      one.x.push(px);
      one.y.push(py);
      one.state.push(state);
      if (lostX !== undefined) (one.lost.x.push(lostX), one.lost.y.push(lostY));
      Object.assign(one, sights(one.state));
    }
    this.last += 1;
    this.end = this.last * this.dt;
    if (ending) {
      this.touched = new Set(touched);
      this.events.push({ frame: this.last, what: ending, ped: touched[0] ?? null });
    }
  }
}

// Draws speed, command and acceleration over time below the drawing, with the events marked above them.

const STRIPS = [
  { name: "speed", title: "speed [m/s]", low: 0, high: 9, lines: [0, 4, 8] },
  { name: "command", title: "acceleration that the driver commands [m/s²]", low: -3.5, high: 3.5, lines: [-3, 0, 3] },
  { name: "acceleration", title: "acceleration of the car [m/s²]", low: -3.5, high: 3.5, lines: [-3, 0, 3] },
];
const MARKS = 18, GAP = 20, LEFT = 34, RIGHT = 8; // pixels: the row of marks, between strips, and beside them
const SIGNS = { crosswalk: "●", jaywalk: "◆", brake: "▼", collision: "✕", goal: "⚑", timeout: "■" };

class Strips {
  constructor(canvas) {
    this.canvas = canvas;
  }

  timeAt = (px, end) => ((px - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT)) * end;

  // Episodes side by side: the first drawn solid, the second dashed.
  draw(episodes, time, end) {
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const c = this.canvas.getContext("2d"), colour = palette(this.canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    c.font = "11px system-ui, sans-serif";
    const across = (t) => LEFT + (t / end) * (width - LEFT - RIGHT);
    const tall = (height - MARKS - GAP * STRIPS.length) / STRIPS.length;
    for (const [k, strip] of STRIPS.entries()) {
      const bottom = MARKS + (k + 1) * (tall + GAP) - 6;
      const share = (value) => (value - strip.low) / (strip.high - strip.low);
      const up = (value) => bottom - Math.min(Math.max(share(value), 0), 1) * tall; // off the road, speed halves in a step
      this.#scale(c, colour, strip, up, width, bottom - tall - 4);
      for (const [i, episode] of episodes.entries()) {
        c.beginPath();
        episode.car[strip.name].forEach((value, frame) => c.lineTo(across(frame * episode.dt), up(value)));
        c.setLineDash(i ? [5, 4] : []);
        c.strokeStyle = i ? colour.ink : colour.car;
        c.lineWidth = 1.8;
        c.stroke();
        c.setLineDash([]);
      }
    }
    this.#marks(c, colour, episodes[0], across);
    c.beginPath();
    c.moveTo(across(time), 0);
    c.lineTo(across(time), height);
    c.strokeStyle = colour.ink;
    c.lineWidth = 1.5;
    c.stroke();
  }

  #scale(c, colour, strip, up, width, top) {
    c.textAlign = "right";
    for (const value of strip.lines) {
      c.beginPath();
      c.moveTo(LEFT, up(value));
      c.lineTo(width - RIGHT, up(value));
      c.strokeStyle = colour.grid;
      c.lineWidth = 1;
      c.stroke();
      c.fillStyle = colour.ink;
      c.fillText(String(value), LEFT - 5, up(value) + 4);
    }
    c.textAlign = "left";
    c.fillText(strip.title, LEFT, top);
  }

  #marks(c, colour, episode, across) {
    c.textAlign = "center";
    for (const event of episode.events) {
      c.fillStyle = event.what === "jaywalk" || event.what === "collision" ? colour.goal : colour.ink;
      c.fillText(SIGNS[event.what], across(event.frame * episode.dt), MARKS - 5);
    }
  }
}

// An event in words.
function said(event) {
  const who = event.ped === null ? "" : `pedestrian ${event.ped + 1}`;
  return {
    crosswalk: `${who} steps onto a crosswalk`,
    jaywalk: `${who} jaywalks`,
    brake: `the car begins to brake, with ${who} on the road`,
    collision: `collision with ${who}`,
    goal: "the car reaches its goal",
    timeout: "out of time",
  }[event.what];
}

"""One episode as a figure, which can show any of its frames."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from jaxwalk.maps.network import Network
from jaxwalk.maps.parking_slots import box_corners
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.perceived import KEPT
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory
from jaxwalk.viewer.ground import draw_ground

CAR_LENGTH, CAR_WIDTH = SimConfig.car_length, SimConfig.car_width
"""Size of the drawn car [m]."""
CAR, JAYWALKED, GOAL, CRASH = "#1f5fd0", "#ffd400", "#d81e2c", "#d81e2c"
"""Colours of the car, of jaywalks, of the goal and of a collision."""
PARKED, LAST_SEEN, OUTLINE = "#4d5663", "#7a1fb8", "#222222"
"""Colours of parked vehicles, of where somebody was last seen, and of people's outlines."""
PALE, FAINTEST = 0.3, 0.15
"""Opacity of who isn't perceived, and the lowest of where somebody was last seen."""
DASHED = (0, (2, 1.5))
TENDENCY = LinearSegmentedColormap.from_list("tendency", ["#fff4d6", "#f5b242", "#cd540a", "#541408"])
"""Colours from pale (never jaywalks) to dark, as in ``page/drawing.js``. They differ in lightness, which colour-blind
people see too."""
INCHES = 8.0
"""Width of the figure for which texts and lines are sized; the pixels per inch scale it."""
AROUND = 0.13
"""Height of title and legend, as a share of the figure's width."""
FLATTEST = 0.3
"""The smallest height of a map, as a share of its width, for which the figure becomes flatter."""
TRAIL = 3.0
"""Length of the trail behind each pedestrian [s]."""


class ViewerError(ValueError):
    """A drawing is impossible. The message says why and what to do, in one line."""


class EpisodeFigure:
    """A figure of one episode; `show` moves it to a frame.

    Args:
        trajectory: recorded episodes.
        episode: the episode to draw, from 0.
        network: the street it was played on, as `load_network` returns it.
        width: width of the figure in pixels; the height is about the same, and less for a map wider than high.

    Raises:
        ViewerError: there is no such episode.
    """

    def __init__(self, trajectory: Trajectory, episode: int, network: Network, *, width: int = 960) -> None:
        """Draw everything that doesn't move."""
        episodes = len(trajectory.length)
        if not 0 <= episode < episodes:
            raise ViewerError(f"there is no episode {episode}: the trajectory has {episodes}, from 0")
        self.trajectory, self.episode = trajectory, episode
        self.last = int(trajectory.length[episode])
        width_to_east, height_to_north = network.size
        height = INCHES * (AROUND + (0.98 - AROUND) * float(np.clip(height_to_north / width_to_east, FLATTEST, 1)))
        self.figure = Figure(figsize=(INCHES, height), dpi=width / INCHES, layout=ConstrainedLayoutEngine())
        self.canvas = FigureCanvasAgg(self.figure)
        self.axes = self.figure.add_subplot()
        draw_ground(self.axes, network)
        self.axes.set_xlabel("m")
        self.axes.tick_params(labelsize=8)
        self.jaywalks = _jaywalks(trajectory, episode)
        self._add_artists()
        self._add_legend()
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # the layout is computed once
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()  # without the animated artists
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)

    def refresh(self) -> None:
        """Read the trajectory again after frames were added to it."""
        self.last = int(self.trajectory.length[self.episode])
        self.jaywalks = _jaywalks(self.trajectory, self.episode)

    def show(self, frame: int) -> None:
        """Move the figure to a frame (0 to the episode's length)."""
        t, e = self.trajectory, self.episode
        self.car.set_xy(_outline(t.car_x[frame, e], t.car_y[frame, e], t.car_cos[frame, e], t.car_sin[frame, e]))
        self.path.set_data(t.car_x[: frame + 1, e], t.car_y[: frame + 1, e])
        self.people.set_offsets(np.stack([t.ped_x[frame, e], t.ped_y[frame, e]], axis=-1))
        begin = max(0, frame - round(TRAIL / t.dt))
        self.trails.set_segments(list(_paths(t, e, begin, frame).transpose(1, 0, 2)))
        self._show_sight(frame)
        walked = [
            _paths(t, e, enter, min(leave, frame))[:, ped] for ped, enter, leave in self.jaywalks if enter < frame
        ]
        self.yellow.set_segments(walked)
        self.title.set_text(self._caption(frame))
        hit = frame == self.last and bool(t.collision[e])
        self.crash.set_visible(hit)

    def _show_sight(self, frame: int) -> None:
        """Show who isn't perceived, and where the car last saw them."""
        t, e = self.trajectory, self.episode
        if self.last_seen is None:  # a recording without perception
            return
        seen = (t.perceived, t.last_seen_x, t.last_seen_y, t.last_seen_age)
        now, x, y, age = (np.asarray(column)[frame, e] for column in seen)
        faces = TENDENCY(t.jaywalking_tendency[e])
        faces[~now, 3] = PALE
        self.people.set_facecolor(faces)
        self.people.set_linestyle(["-" if perceived else DASHED for perceived in now])
        lost = ~now & (age <= KEPT)
        self.last_seen.set_offsets(np.stack([x, y], axis=-1)[lost])
        rings = np.tile(to_rgba(LAST_SEEN), (int(lost.sum()), 1))
        rings[:, 3] = np.maximum(FAINTEST, 1 - age[lost] / KEPT)
        self.last_seen.set_edgecolor(rings.tolist())

    def pixels(self, frame: int) -> UInt8[np.ndarray, "height width 3"]:
        """Return a frame as an image. Only the moving artists are drawn again."""
        self.show(frame)
        self.canvas.restore_region(self.background)
        for artist in self.moving:
            self.axes.draw_artist(artist)
        return np.array(self.canvas.buffer_rgba())[..., :3]

    def _caption(self, frame: int) -> str:
        t, e = self.trajectory, self.episode
        text = f"{frame * t.dt:4.1f} s    {t.car_speed[frame, e]:4.1f} m/s"
        if frame < self.last:
            return text
        ending = "collision" if t.collision[e] else "goal reached" if t.goal[e] else "out of time"
        return f"{text}    {ending}"

    def _add_artists(self) -> None:
        """Add everything that moves, still empty."""
        t, e, axes = self.trajectory, self.episode, self.axes
        colours = TENDENCY(t.jaywalking_tendency[e])
        if t.parked is not None:
            boxes = box_corners(t.parked_in(e))
            axes.add_collection(
                PolyCollection(list(boxes), facecolors=PARKED, edgecolors="white", linewidths=0.5, zorder=4)
            )
        self.path = axes.plot([], [], color=CAR, linewidth=2, alpha=0.7, zorder=5)[0]
        self.yellow = LineCollection([], colors=JAYWALKED, linewidths=3.5, capstyle="round", zorder=6)
        self.trails = LineCollection([], colors=colours, linewidths=1.6, alpha=0.7, zorder=7)
        axes.add_collection(self.yellow)
        axes.add_collection(self.trails)
        axes.plot(t.goal_x[e], t.goal_y[e], "x", color=GOAL, markersize=13, markeredgewidth=3.5, zorder=8)
        self.car = Polygon(np.zeros((5, 2)), facecolor=CAR, edgecolor="#0b2a66", linewidth=1, zorder=9)
        axes.add_patch(self.car)
        self.people = axes.scatter(
            t.ped_x[0, e], t.ped_y[0, e], s=46, c=colours, edgecolors=OUTLINE, linewidths=0.9, zorder=10
        )
        self.last_seen: PathCollection | None = None
        if t.perceived is not None:
            self.last_seen = axes.scatter(
                [], [], s=80, facecolors="none", linewidths=1.6, linestyles=[DASHED], zorder=9.5
            )
        self.crash = axes.plot(
            t.car_x[self.last, e], t.car_y[self.last, e], marker="o", markersize=34, markerfacecolor="none",
            markeredgecolor=CRASH, markeredgewidth=3, linestyle="none", zorder=11, visible=False,
        )[0]  # fmt: skip
        self.title = axes.set_title("0", fontfamily="monospace", fontsize=12, loc="left")
        rings = () if self.last_seen is None else (self.last_seen,)
        self.moving = (self.path, self.yellow, self.trails, self.car, *rings, self.people, self.crash, self.title)

    def _add_legend(self) -> None:
        scale = ScalarMappable(Normalize(0, 1), TENDENCY)
        bar = self.figure.colorbar(scale, ax=self.axes, shrink=0.6, aspect=28, pad=0.015)
        bar.set_label("jaywalking tendency", fontsize=9)
        bar.ax.tick_params(labelsize=8)
        handles = [
            Line2D([], [], color=CAR, linewidth=6, label="car"),
            Line2D([], [], color=CAR, linewidth=2, alpha=0.7, label="its path"),
            Line2D([], [], color=GOAL, marker="x", markersize=9, markeredgewidth=3, linestyle="none", label="its goal"),
            Line2D([], [], color="#cd540a", marker="o", markeredgecolor=OUTLINE, label="pedestrian, last 3 s"),
            Line2D([], [], color=JAYWALKED, linewidth=3.5, label="jaywalk"),
            *self._handles_of_sight(),
        ]
        columns = -(-len(handles) // 2) if len(handles) > 5 else 5
        self.legend = self.figure.legend(
            handles=handles, loc="outside lower center", ncols=columns, fontsize=9, frameon=False,
            columnspacing=1.4, handlelength=1.6,
        )  # fmt: skip

    def _handles_of_sight(self) -> list[Line2D | PathCollection]:
        """Return the legend's handles of what only some worlds have."""
        found: list[Line2D | PathCollection] = []
        if self.trajectory.parked is not None:
            found.append(Line2D([], [], color=PARKED, linewidth=6, label="parked vehicle"))
        if self.trajectory.perceived is not None:
            rings = {"linestyles": [DASHED], "facecolors": (*to_rgba("#cd540a")[:3], PALE), "edgecolors": OUTLINE}
            found.append(self.axes.scatter([], [], s=46, label="not perceived by the car", **rings))
            rings |= {"facecolors": "none", "edgecolors": LAST_SEEN}
            found.append(self.axes.scatter([], [], s=80, linewidths=1.6, label=f"last seen, {KEPT:g} s", **rings))
        return found


def _outline(x: np.floating, y: np.floating, cos: np.floating, sin: np.floating) -> Float[np.ndarray, "corner 2"]:
    """Return the car's outline from above [m]: a rectangle with a slightly pointed front, which shows its heading."""
    ahead, left = CAR_LENGTH / 2, CAR_WIDTH / 2
    shape = np.array([(-ahead, -left), (0.8 * ahead, -left), (ahead, 0), (0.8 * ahead, left), (-ahead, left)])
    return shape @ np.array([(cos, sin), (-sin, cos)]) + (x, y)


def _paths(trajectory: Trajectory, episode: int, begin: int, end: int) -> Float[np.ndarray, "frame ped 2"]:
    """Return the positions of all pedestrians from one frame to another [m], both included."""
    frames = slice(begin, end + 1)
    return np.stack([trajectory.ped_x[frames, episode], trajectory.ped_y[frames, episode]], axis=-1)


def _jaywalks(trajectory: Trajectory, episode: int) -> list[tuple[int, int, int]]:
    """Return every jaywalk: pedestrian, frame before it enters the roadway, frame after it leaves it."""
    last = int(trajectory.length[episode])
    on = trajectory.on_roadway[: last + 1, episode] & (trajectory.crossing[: last + 1, episode] == JAYWALK)
    found = []
    for ped in range(on.shape[1]):
        edges = np.flatnonzero(np.diff(np.pad(on[:, ped], 1).astype(np.int8)))
        found += [(ped, max(int(a) - 1, 0), min(int(b), last)) for a, b in edges.reshape(-1, 2)]
    return found

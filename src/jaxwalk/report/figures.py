"""The figures: ours with 95 % intervals, the paper's numbers as open diamonds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from jaxwalk.metrics import interquartile_mean
from jaxwalk.report import published
from jaxwalk.report.frontier import frontier
from jaxwalk.report.material import ALWAYS_GO, CO_TRAINED, LEARNED, POPULATIONS, ROUTE_FOLLOWER, Material, Number
from jaxwalk.report.style import BLUE, GREEN, GRID, INK, ORANGE, PAPER, PURPLE, RED, SKY, drawing, panels, save

RATES = (("goal_rate", "goals [%]", 0), ("collision_rate", "collisions [%]", 1))
"""What to show, its label, and its place in the paper's pairs."""
COLOURS = {ALWAYS_GO: ORANGE, LEARNED: BLUE}
TYPES = {"crosswalk": BLUE, "jaywalk": RED}
SMOOTH = 20
"""Learning curves are running means over this share (one in so many) of the training."""


def draw_all(material: Material, folder: Path) -> dict[str, str]:
    """Write every figure; returns drawings for the page, by name."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {}
    for name, draw in FIGURES.items():
        with drawing(name):
            made[name] = save(draw(material), folder, name)
    return made


def baselines(material: Material) -> Figure:
    """Goals and collisions of every driver, among both populations."""
    figure, axes = panels(2, height=4.2, sharey=True)
    names = material.drivers
    for axis, (rate, unit, place) in zip(axes, RATES, strict=True):
        for k, people in enumerate(POPULATIONS):
            ours = [material.over_seeds(name, people)[rate] for name in names]
            where = [i + 0.17 * (2 * k - 1) for i in range(len(names))]
            means, label = [number["mean"] for number in ours], f"ours, among {people}"
            _points(axis, means, where, color=COLOURS[people], label=label, scale=100.0, flat=True)
            _each_seed(axis, ours, where, "each training seed" if k == 0 and material.several else None)
        for i, name in enumerate(names):
            for value in _published(name, place):
                axis.plot(value, i, **_DIAMOND, label="paper" if i == 0 else None)
        axis.set(xlabel=unit, xlim=(-2, 102))
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _each_seed(axis: Axes, ours: list[Number], where: list[float], label: str | None) -> None:
    """A dot for each training seed, where there are several."""
    several = [(number["each"], place) for number, place in zip(ours, where, strict=True) if len(number["each"]) > 1]
    values = [100 * value for each, _ in several for value in each]
    places = [place for each, place in several for _ in each]
    axis.plot(values, places, color=INK, marker=".", markersize=4, linestyle="none", zorder=5, label=label)


def _published(driver: str, place: int) -> list[float]:
    if driver in published.BASELINES:
        return [published.BASELINES[driver][place]]
    return [pair[place] for (name, _), pair in published.TRAINED.items() if name == driver]


def speed_differential(material: Material) -> Figure:
    """Car speed by distance to the nearest pedestrian on a roadway, by type; the gap shaded, and drawn at the right."""
    figure, axes = panels(3, width=10.0, height=3.8)
    bins = material.cell(CO_TRAINED, LEARNED)["speed_differential"]
    for axis, (weight, title, _) in zip(axes, WEIGHTS, strict=False):
        _speeds(axis, bins, weight)
        axis.set(title=f"car speed, {title} [m/s]", ylim=(0, 9))
    for value in published.SPEEDS:
        axes[0].plot(_middle(bins[0]), value, **_DIAMOND, label="paper" if value == published.SPEEDS[0] else None)
    _gaps(axes[2], bins)
    for axis in axes:
        axis.set(xlim=(0, bins[-1]["far"]), xticks=[0, *(b["far"] for b in bins)])
    axes[1].set_xlabel("distance to the nearest pedestrian of the type [m]")
    named = [axis.get_legend_handles_labels() for axis in (axes[0], axes[2])]
    handles, labels = (left + right for left, right in zip(*named, strict=True))
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _middle(b: dict[str, float]) -> float:
    return (b["near"] + b["far"]) / 2


def _speeds(axis: Axes, bins: list[dict[str, Any]], weight: str) -> None:
    """Speeds near both types, and the gap between them."""
    middles, lines = [_middle(b) for b in bins], {}
    for k, (kind, colour) in enumerate(TYPES.items()):
        ours = [b[weight][kind] for b in bins]
        where = [m + 0.16 * (2 * k - 1) for m in middles]
        _points(axis, ours, where, color=colour, label=f"near {kind}", scale=1.0, line=True)
        lines[kind] = [math.nan if x["value"] is None else x["value"] for x in ours]
    axis.fill_between(middles, lines["crosswalk"], lines["jaywalk"], color=GRID, alpha=0.25, label="gap", lw=0)


def _gaps(axis: Axes, bins: list[dict[str, Any]]) -> None:
    """The differences with both weights, beside the paper's."""
    for k, (weight, title, colour) in enumerate(WEIGHTS):
        ours = [b[weight]["difference"] for b in bins]
        where = [_middle(b) + 0.16 * (2 * k - 1) for b in bins]
        _points(axis, ours, where, color=colour, label=title, scale=1.0, line=True)
    axis.plot(_middle(bins[0]), published.SPEED_GAP, **_DIAMOND)
    low, high = published.SPEED_GAP_FARTHER
    axis.fill_between([bins[1]["near"], bins[-1]["far"]], low, high, alpha=0.25, color=SKY, lw=0, label="paper, 3-12 m")
    axis.axhline(0, color=INK, lw=0.8)
    axis.set_title("jaywalk minus crosswalk [m/s]")


WEIGHTS = (("pooled", "pooled over frames", PURPLE), ("by_encounter", "by encounter", GREEN))
"""How speeds are averaged, in words, and the colour."""


def attribution(material: Material) -> Figure:
    """Jaywalking's share of collisions beside its share of crossings, encounters and time."""
    figure, (axis,) = panels(1, height=3.0)
    places = [(0.17 * (2 * k - 1), people) for k, people in enumerate(POPULATIONS)]
    names = list(SHARES)
    for shift, people in places:
        found = material.cell(CO_TRAINED, people)["attribution"]
        ours = [find(found) for find in SHARES.values()]
        where = [i + shift for i in range(len(names))]
        _points(axis, ours, where, color=COLOURS[people], label=f"ours, among {people}", scale=100.0, flat=True)
    for i, value in ((0, published.COLLISIONS_JAYWALK), (1, published.CROSSINGS_JAYWALK)):
        axis.plot(value, i, **_DIAMOND, label="paper" if i == 0 else None)
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.set(xlabel="share that is jaywalking [%]", xlim=(-2, 102))
    figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


SHARES: dict[str, Callable[[dict], Number]] = {
    "of collisions on a roadway": lambda a: a["share"],
    "of crossings": lambda a: a["per_crossing"]["share"],
    "of encounters": lambda a: a["per_encounter"]["share"],
    "of time on a roadway": lambda a: a["per_second"]["share"],
    "of that, car within 20 m": lambda a: a["per_second_near"]["share"],
}
"""Jaywalking's shares, by what they are of."""


def quarters(material: Material) -> Figure:
    """Jaywalk rate by quarter of the trait."""
    figure, (axis,) = panels(1, width=5.0, height=3.2)
    found = material.cell(CO_TRAINED, LEARNED)["jaywalk_rate"]["quarters"]
    _points(axis, found, [0.0, 1.0, 2.0, 3.0], color=BLUE, label="ours", scale=100.0)
    for i, value in enumerate(published.QUARTERS):
        axis.plot(i + 0.12, value, **_DIAMOND, label="paper" if i == 0 else None)
    axis.set_xticks(range(4), ["0 to 0.25", "0.25 to 0.5", "0.5 to 0.75", "0.75 to 1"])
    axis.set(xlabel="jaywalking tendency", ylabel="decisions to jaywalk [%]", ylim=(0, None), xlim=(-0.5, 3.5))
    axis.legend(loc="upper left")
    return figure


def waiting(material: Material) -> Figure:
    """Wait rate at the kerb by the car's distance and by its speed, for each predicted miss; a driver in each row."""
    figure, axes = panels(2, rows=len(KERB_DRIVERS), height=3.0 * len(KERB_DRIVERS) + 0.4, sharey=True)
    places = [(driver, by, label) for driver in KERB_DRIVERS for by, label in KERB_AXES.items()]
    for axis, (driver, by, label) in zip(axes, places, strict=True):
        bins = material.cell(driver, LEARNED)["waiting"][by]
        width = bins[0]["end"] - bins[0]["begin"]
        for k, (name, colour) in enumerate(MISSES.items()):
            known = [b for b in bins if b["rates"][k]["count"] >= FEWEST]
            where = [(b["begin"] + b["end"]) / 2 + 0.08 * width * (k - 1.5) for b in known]
            _points(axis, [b["rates"][k] for b in known], where, color=colour, label=name, scale=100.0, line=True)
        axis.set(title=f"before {driver}", xlabel=label, ylim=(-3, 103))
        edges = [0, *(b["end"] for b in bins)]
        axis.set_xticks(edges, [f"{x:g}" for x in edges])
    for axis in axes[::2]:
        axis.set_ylabel("waits at the kerb [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, title="predicted miss")
    return figure


KERB_DRIVERS = (ROUTE_FOLLOWER, CO_TRAINED)
"""Before whom people wait: the driver that heeds nobody, and the one that learned with them."""
KERB_AXES = {"by_distance": "distance of the car [m]", "by_speed": "speed of the car [m/s]"}
MISSES = {"below 1 m": RED, "1 to 2.5 m": ORANGE, "2.5 to 5 m": SKY, "5 m or more": GRID}
"""The predicted misses, in the order of a bin's rates."""
FEWEST = 20
"""Bins of fewer kerb moments are not drawn: if nobody waited there, the bootstrap would call that certain."""


def ablation(material: Material) -> Figure:
    """Goals and collisions of the co-trained driver by jaywalk multiplier."""
    figure, axes = panels(2)
    for axis, (rate, label, place) in zip(axes, RATES, strict=True):
        for k, people in enumerate(POPULATIONS):
            ours = [material.ablated(m, people)[rate]["mean"] for m in material.multipliers]
            where = [m + 0.01 * (2 * k - 1) for m in material.multipliers]
            _points(axis, ours, where, color=COLOURS[people], label=f"ours, among {people}", scale=100.0, line=True)
        theirs = [pair[place] for pair in published.ABLATION.values()]
        style: dict[str, Any] = _DIAMOND | {"linestyle": ":", "label": "paper, among always-go"}
        axis.plot(list(published.ABLATION), theirs, **style)
        axis.set(xlabel="jaywalk multiplier", ylabel=label, ylim=(0, 100 if place == 0 else None))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def learning_curves(material: Material) -> Figure:
    """Goals and collisions during training, of the episodes that ended in each update."""
    figure, axes = panels(2, sharey=True)
    shown = ENDINGS[:2] if material.several else ENDINGS
    for axis, (name, curves) in zip(axes, material.curves.items(), strict=True):
        for rate, colour in shown:
            _curve(axis, list(curves.values()), rate, colour)
        axis.set(title=name, xlabel="environment steps [million]", ylim=(0, 100))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x / 1e6:g}"))
    axes[0].set_ylabel("episodes [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


ENDINGS = (("goal_rate", GREEN), ("collision_rate", RED), ("timeout_rate", GRID))
"""Of the learning curves, with their colours; timeouts only where there is room, with one training seed."""


def _curve(axis: Axes, curves: list[list[dict[str, Any]]], rate: str, colour: str) -> None:
    """The interquartile mean over training seeds and, if there are several, a thin line for each."""
    steps = [line["steps"] for line in curves[0]]
    seeds = [_running_mean([line[rate] for line in lines], [line["episodes"] for line in lines]) for lines in curves]
    found = 100 * np.transpose(seeds)
    if len(curves) > 1:
        axis.plot(steps, found, color=colour, lw=0.6, alpha=0.5)
    label = rate.removesuffix("_rate") + (", IQM" if len(curves) > 1 else "")
    axis.plot(steps, interquartile_mean(found), color=colour, lw=2.0 if len(curves) > 1 else None, label=label)


def _running_mean(values: list[float], weights: list[float]) -> list[float]:
    """Weighted means over the last stretch up to each value; NaN before the first episode ends."""
    width = max(1, len(values) // SMOOTH)
    means = []
    for i in range(len(values)):
        part = slice(max(0, i + 1 - width), i + 1)
        total = sum(weights[part])
        means.append(
            sum(v * w for v, w in zip(values[part], weights[part], strict=True)) / total if total else math.nan
        )
    return means


_DIAMOND: dict[str, Any] = {
    "color": PAPER,
    "marker": "D",
    "markersize": 7,
    "markerfacecolor": "none",
    "linestyle": "none",
    "zorder": 4,
}
"""How the paper's numbers look."""


def _points(
    axis: Axes, ours: Iterable[Number], where: Iterable[float], *,
    color: str, label: str, scale: float, flat: bool = False, line: bool = False,
) -> None:  # fmt: skip
    """Numbers with their intervals; ``flat``: values go to the right, places up."""
    shown = [(place, n) for place, n in zip(where, ours, strict=True) if n["value"] is not None]
    values = [scale * n["value"] for _, n in shown]
    below = [scale * (n["value"] - _end(n, "low")) for _, n in shown]
    above = [scale * (_end(n, "high") - n["value"]) for _, n in shown]
    places, bars = [place for place, _ in shown], [below, above]
    style: dict[str, Any] = {"color": color, "marker": "o", "markersize": 5, "capsize": 2.5, "label": label}
    style["linestyle"] = "-" if line else "none"
    if flat:
        axis.errorbar(values, places, xerr=bars, **style)
    else:
        axis.errorbar(places, values, yerr=bars, **style)


def _end(number: Number, name: str) -> float:
    return number["value"] if number[name] is None else number[name]


FIGURES: dict[str, Callable[[Material], Figure]] = {
    "baselines": baselines,
    "frontier": frontier,
    "speed_differential": speed_differential,
    "attribution": attribution,
    "quarters": quarters,
    "waiting": waiting,
    "ablation": ablation,
    "learning_curves": learning_curves,
}
"""Every figure, by name of its files."""

"""What people do: jaywalking's share of what happens, who jaywalks, and who waits at the kerb."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics import ATTRIBUTION, JAYWALK_RATE, WAITING
from jaxwalk.metrics.attribution import Attribution
from jaxwalk.metrics.waiting import WaitBin, Waiting
from jaxwalk.report import published
from jaxwalk.report.figures.marks import DIAMOND, PointStyle, points, populations
from jaxwalk.report.material import ROUTE_FOLLOWER, Material
from jaxwalk.report.style import BLUE, COLUMN, GRID, ORANGE, RED, SKY, panels

SHARES: dict[str, Callable[[Attribution], Number]] = {
    "of collisions on a roadway": lambda a: a.share,
    "of crossings": lambda a: a.per_crossing.share,
    "of encounters": lambda a: a.per_encounter.share,
    "of time on a roadway": lambda a: a.per_second.share,
    "of that, car within 20 m": lambda a: a.per_second_near.share,
}
"""Jaywalking's shares, by what they are shares of."""


def attribution(material: Material) -> Figure:
    """Draw jaywalking's share of collisions next to its share of crossings, encounters and time."""
    figure, (axis,) = panels(1, height=2.6)
    names = list(SHARES)
    for people, colour, aside in populations(material.populations, spread=0.34):
        found = material.cell(material.subject, people).summary[ATTRIBUTION]
        ours = [find(found) for find in SHARES.values()]
        where = [i + aside for i in range(len(names))]
        points(axis, ours, where, PointStyle(color=colour, label=f"ours, among {people}", scale=100.0, flat=True))
    theirs = (published.COLLISIONS_JAYWALK, published.CROSSINGS_JAYWALK) if material.beside_paper else ()
    for i, value in enumerate(theirs):
        axis.plot(value, i, **DIAMOND, label="paper" if i == 0 else None)
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.set(xlabel="share that is jaywalking [%]", xlim=(-2, 102))
    figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def quarters(material: Material) -> Figure:
    """Draw the jaywalk rate by quarter of the trait."""
    figure, (axis,) = panels(1, width=COLUMN, height=2.6)
    found = material.cell(material.subject, material.crowd).summary[JAYWALK_RATE].quarters
    points(axis, found, [0.0, 1.0, 2.0, 3.0], PointStyle(color=BLUE, label="ours", scale=100.0))
    for i, value in enumerate(published.QUARTERS if material.beside_paper else ()):
        axis.plot(i + 0.12, value, **DIAMOND, label="paper" if i == 0 else None)
    axis.set_xticks(range(4), ["0 to 0.25", "0.25 to 0.5", "0.5 to 0.75", "0.75 to 1"])
    axis.set(xlabel="jaywalking tendency", ylabel="decisions to jaywalk [%]", ylim=(0, None), xlim=(-0.5, 3.5))
    axis.legend(loc="upper left")
    return figure


KERB_AXES: dict[str, Callable[[Waiting], tuple[WaitBin, ...]]] = {
    "distance of the car [m]": lambda waiting: waiting.by_distance,
    "speed of the car [m/s]": lambda waiting: waiting.by_speed,
}
MISSES = {"below 1 m": RED, "1 to 2.5 m": ORANGE, "2.5 to 5 m": SKY, "5 m or more": GRID}
"""The predicted misses, in the order of a bin's rates."""
FEWEST = 20
"""Bins with fewer kerb moments are not drawn: the interval of so few fills half the axis."""


def waiting(material: Material) -> Figure:
    """Draw the wait rate at the kerb by the car's distance and speed, for each predicted miss; one driver per row."""
    # the driver that ignores people, and the subject
    drivers = list(dict.fromkeys(d for d in (ROUTE_FOLLOWER, material.subject) if d in material.drivers))
    figure, axes = panels(2, rows=len(drivers), height=2.9 * len(drivers) + 0.4, sharey=True)
    places = [(driver, label) for driver in drivers for label in KERB_AXES]
    for axis, (driver, label) in zip(axes, places, strict=True):
        bins = KERB_AXES[label](material.cell(driver, material.crowd).summary[WAITING])
        width = bins[0].end - bins[0].begin
        for k, (name, colour) in enumerate(MISSES.items()):
            drawn_as = PointStyle(color=colour, label=name, scale=100.0, line=True)
            known = [b for b in bins if b.rates[k].count >= FEWEST]
            where = [(b.begin + b.end) / 2 + 0.08 * width * (k - 1.5) for b in known]
            points(axis, [b.rates[k] for b in known], where, drawn_as)
        axis.set(title=f"before {driver}", xlabel=label, ylim=(-3, 103))
        edges = [0, *(b.end for b in bins)]
        axis.set_xticks(edges, [f"{x:g}" for x in edges])
    for axis in axes[::2]:
        axis.set_ylabel("waits at the kerb [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, title="predicted miss")
    return figure

"""The report of one street, from what was mapped, placed, joined and left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
import shapely.ops

from jaxwalk.maps.imported.crossing_places import CrossingOutcome, Placed
from jaxwalk.maps.imported.kerb_origins import Stretch, touching
from jaxwalk.maps.imported.source_map import StreetFrame
from jaxwalk.maps.imported.street_report import (
    CrossingFacts,
    Kerbside,
    PavementNumbers,
    Repair,
    StreetReport,
    Verdict,
)
from jaxwalk.maps.network import Network

MUCH = 0.3
"""A street that has no sidewalk in the source along more than this share of its kerbs is advised to map them."""


class Built(NamedTuple):
    """What a street was made of."""

    mapped: tuple[Placed, ...]
    """Crossings of the source that could be placed."""
    kept: tuple[Placed, ...]
    """All crossings of the street."""
    walks: list[int]
    """The lines of people that are connected."""
    stretches: list[Stretch]
    """The stretches of all lines of people."""
    outcomes: tuple[CrossingOutcome, ...]
    met: Sequence[bool] = ()
    """Which of the crossings some route meets."""
    lines: Sequence[shapely.LineString] = ()
    """All lines of people."""


def summary(name: str, frame: StreetFrame, built: Built, reason: str, network: Network | None = None) -> StreetReport:
    """Return the report of a street; ``reason`` says why it isn't usable, if it isn't."""
    pavement = _pavement(built)
    repairs = tuple(_repairs(built, frame))
    no_pavement = tuple(_without_pavement(built))
    reasons = (reason,) if reason else tuple(_not_mapped(built, pavement))
    verdict: Verdict = "not usable" if reason else "usable with inferred parts" if reasons else "usable"
    return StreetReport(
        name=name,
        verdict=verdict,
        reasons=reasons,
        advice=tuple(_advice(built, pavement, frame)),
        place=frame.box,
        pavement=pavement,
        crossings=built.outcomes,
        counts={} if network is None else _counts(network),
        facts=tuple(_facts(built, frame, network)),
        kerbsides=tuple(_kerbsides(built, frame)),
        no_pavement=no_pavement,
        repairs=repairs,
        signals=tuple(x.name for x in built.kept if x.kind == "signals"),
        left_out=tuple(_left_out(built)),
    )


def _counts(network: Network) -> dict[str, int]:
    """Return the numbers of a street's parts."""
    kinds = [area.kind for area in network.areas]
    return {
        "crossings": len(network.crossings),
        "crossings with a jaywalk zone": sum(x.zone is not None for x in network.crossings),
        "islands": kinds.count("island"),
        "lanes": len(network.lanes),
        "routes": len(network.routes),
        "waypoints": network.walk.waypoints,
        "parking strips": kinds.count("parking"),
        "buildings": kinds.count("building"),
    }


def _facts(built: Built, frame: StreetFrame, network: Network | None) -> Iterator[CrossingFacts]:
    """Yield the facts of a street's crossings."""
    crossings = () if network is None else network.crossings
    for placed, crossing in zip(built.kept, crossings, strict=False):
        chord = placed.chord
        roadway = round(float((chord.over[:, 1] - chord.over[:, 0]).sum()), 1)
        yield CrossingFacts(
            placed.name, placed.kind, placed.kind_origin, placed.origin, _in_street(chord.at(chord.length / 2), frame),
            roadway, len(placed.islands), crossing.zone is not None,
        )  # fmt: skip


def _in_street(point: np.ndarray, frame: StreetFrame) -> tuple[float, float]:
    """Return a point of the source map (2,) in the street [m]."""
    x, y = frame.placed(point, 1).tolist()
    return x, y


def _kerbsides(built: Built, frame: StreetFrame) -> Iterator[Kerbside]:
    """Yield the stretches of pavement."""
    for stretch in built.stretches if built.lines else ():
        part = shapely.ops.substring(built.lines[stretch.walk], stretch.begin, stretch.end).simplify(0.2)
        line = frame.placed(shapely.get_coordinates(part), 1).tolist()
        origin = "joined" if stretch.joined else stretch.origin
        yield Kerbside(origin, round(stretch.metres, 1), line, stretch.walk in built.walks)


def _pavement(built: Built) -> PavementNumbers:
    """Return the metres of pavement by where they are from, and how they hang together."""
    stretches = built.stretches

    def metres(origin: str, *, joined: bool = False) -> float:
        return round(sum((s.metres for s in stretches if s.origin == origin and s.joined == joined), 0.0), 1)

    known = [n for n, s in enumerate(stretches) if s.origin != "invented" and not s.joined]
    group = _parts(built)
    sums: dict[int, float] = {}
    for n in known:
        sums[group[n]] = sums.get(group[n], 0.0) + stretches[n].metres
    whole = sum(sums.values())
    kept = sum((stretches[n].metres for n in known if stretches[n].walk in built.walks), 0.0)
    after = _walk_parts(built)
    return PavementNumbers(
        mapped=metres("mapped"),
        inferred=metres("inferred"),
        joined=metres("inferred", joined=True),
        invented=metres("invented"),
        parts_before=len(sums),
        largest_before=round(max(sums.values(), default=0.0) / whole, 3) if whole else 0.0,
        parts_after=after,
        kept=round(kept, 1),
    )


def _parts(built: Built) -> list[int]:
    """Return the connected part of each stretch: known ones that touch, or that a crossing joins."""
    stretches = built.stretches
    group = list(range(len(stretches)))

    def join(one: int, other: int) -> None:
        low, high = group[one], group[other]
        group[:] = [low if x == high else x for x in group]

    for one, other in touching(stretches, built.lines):
        if not any(stretches[n].origin == "invented" or stretches[n].joined for n in (one, other)):
            join(one, other)
    for crossing in built.mapped:
        ends = [_stretch_at(stretches, walk, place) for walk, place in zip(*crossing.chord[1:3], strict=True)]
        known = [n for n in ends if n is not None and stretches[n].origin != "invented" and not stretches[n].joined]
        if len(known) == 2:
            join(*known)
    return group


def _stretch_at(stretches: Sequence[Stretch], walk: int, place: float) -> int | None:
    return next((n for n, s in enumerate(stretches) if s.walk == walk and s.begin <= place <= s.end), None)


def _walk_parts(built: Built) -> int:
    """Return into how many parts the lines of people fall that the source knows of, with all crossings."""
    known = {s.walk for s in built.stretches if s.origin != "invented"}
    return len(known - set(built.walks)) + (1 if built.walks else 0)


def _repairs(built: Built, frame: StreetFrame) -> Iterator[Repair]:
    """Yield the crossings that were invented; the pavement is in the numbers."""
    for crossing in built.kept:
        at = _in_street(crossing.chord.at(crossing.chord.length / 2), frame)
        if crossing.origin == "invented":
            yield Repair(
                "an unmarked crossing that joins two parts of the pavement", round(crossing.chord.length, 1), at
            )
        elif crossing.chord.moved:
            yield Repair(f"{crossing.name} moved along its road", round(crossing.chord.moved, 1), at)


def _without_pavement(built: Built) -> Iterator[str]:
    """Yield the mapped crossings at one of whose kerbs the source has no sidewalk."""
    for crossing in built.mapped:
        ends = [_stretch_at(built.stretches, w, p) for w, p in zip(*crossing.chord[1:3], strict=True)]
        if any(n is None or built.stretches[n].origin == "invented" for n in ends):
            yield crossing.name


def _not_mapped(built: Built, pavement: PavementNumbers) -> Iterator[str]:
    """Yield what isn't mapped, in words."""
    for metres, what in (
        (pavement.inferred, "m of sidewalk are inferred from tags"),
        (pavement.joined, "m of sidewalk close gaps"),
        (pavement.invented, "m of sidewalk are invented"),
    ):
        if metres >= 0.5:
            yield f"{metres:,.0f} {what}"
    invented = sum(x.origin == "invented" for x in built.kept)
    inferred = sum(x.kind_origin == "inferred" and x.origin == "mapped" for x in built.kept)
    if invented:
        yield f"{invented} of {len(built.kept)} crossings are invented"
    if inferred:
        yield f"the kind of {inferred} of {len(built.kept)} crossings is inferred"


def _advice(built: Built, pavement: PavementNumbers, frame: StreetFrame) -> Iterator[str]:
    """Yield what to add to the map."""
    if pavement.without > MUCH:
        yield f"the sidewalks: {pavement.without:.0%} of the kerbs have none in the source"
    if not any(x.origin == "mapped" for x in built.kept):
        yield "crossings: no mapped one can be used here"
    places = [repair.at for repair in _repairs(built, frame) if repair.what.startswith("an unmarked")]
    if places:
        listed = ", ".join(f"({x:.0f}, {y:.0f})" for x, y in places[:8])
        more = f" and {len(places) - 8} more" if len(places) > 8 else ""
        yield f"the crossings at {listed}{more} [m], if they are there"
    for outcome in built.outcomes:
        if not outcome.placed and not outcome.at_edge:
            yield f"{outcome.name}: look at it, because {outcome.reason}"


def _left_out(built: Built) -> Iterator[str]:
    """Yield what of the street isn't played, and why."""
    for crossing in built.kept:
        if crossing.wants_island and not crossing.islands:
            yield f"{crossing.name}: the source has an island there, but no gap between the roadways"
    for crossing, met in zip(built.kept, built.met, strict=False):
        if not met:
            yield f"{crossing.name}: no route of the car leads over it"
    known = {s.walk for s in built.stretches if s.origin != "invented"}
    if lost := known - set(built.walks):
        metres = sum(s.metres for s in built.stretches if s.walk in lost and s.origin != "invented")
        yield f"{metres:.0f} m of sidewalk in {len(lost)} parts that no crossing joins to the others"

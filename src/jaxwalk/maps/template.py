"""A map file to begin with: one straight street with crosswalks, and comments that say what is what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

LANDING, SIDEWALK, VERGE, STRIPES, END = 1.0, 2.0, 4.0, 4.0, 1.0
"""Where people walk, from the kerb; widths of sidewalks, of what lies beyond them, and of crosswalks; and the distance
of the outermost waypoints from the ends of the street [m]."""
LEAST_APART, LEAST_ASIDE = 12.0, 10.0
"""Least distance between the middles of two crosswalks, and from one to the end of the street [m]."""
LONGEST_ZONE = 25.0
"""Length of the longest jaywalk zone [m]."""

HEAD = """\
# A street to begin with. Format and rules: docs, page maps. Check it after each change: jaxwalk map check FILE
# Metres, x to the east, y to the north; rectangles are [x0, y0, x1, y1].
size = [{length:g}, {height:g}]                  # width (east) and height (north)

[car]
places = [[8, {middle:g}], [{last:g}, {middle:g}]]      # where the car may start, and its goals: on the road's middle
routes = "all"                       # or pairs of places, from 0, as in [[0, 1]]
right_turn_radius = 5.0              # how corners are driven, where there are any
left_turn_radius = 8.0

[roads]                              # two lanes each, right-hand traffic
main = [0, {south:g}, {length:g}, {north:g}]

[sidewalks]
south = [0, {south_edge:g}, {length:g}, {south:g}]
north = [0, {north:g}, {length:g}, {north_edge:g}]

[waypoints]                          # where people start and go, on sidewalks
"""


def street_map(length: float, width: float, crosswalks: Sequence[float]) -> str:
    """Return the text of a map file of a straight street with sidewalks.

    Args:
        length: of the street [m].
        width: of its roadway [m].
        crosswalks: how far the middle of each is from the street's western end [m], in rising order.

    Raises:
        ValueError: crosswalks are too near to each other or to an end of the street.
    """
    places = (LEAST_ASIDE - LEAST_APART, *crosswalks)
    near = [b for a, b in pairwise(places) if b - a < LEAST_APART]
    near += [place for place in crosswalks[-1:] if length - place < LEAST_ASIDE]
    if near or not crosswalks:
        raise ValueError(
            f"crosswalks must rise by {LEAST_APART:g} m or more and keep {LEAST_ASIDE:g} m from both ends of the street"
        )
    south, north = VERGE + SIDEWALK, VERGE + SIDEWALK + width
    head = HEAD.format(
        length=length, height=north + SIDEWALK + VERGE, middle=(south + north) / 2, last=length - 8,
        south=south, north=north, south_edge=VERGE, north_edge=north + SIDEWALK,
    )  # fmt: skip
    kerbs = {"south": south - LANDING, "north": north + LANDING}
    return head + "\n".join([*_walkways(length, kerbs, crosswalks), *_crosswalks(length, (south, north), crosswalks)])


def _walkways(length: float, kerbs: dict[str, float], crosswalks: Sequence[float]) -> Iterator[str]:
    """Yield the lines of the waypoints along each kerb, and of the walkways that join them."""
    places = {"west": END} | {str(number): place for number, place in enumerate(crosswalks, 1)} | {"east": length - END}
    for side, y in kerbs.items():
        yield from (f"{side}_{name} = [{place:g}, {y:g}]" for name, place in places.items())
    yield "\n[walkways]                           # waypoints joined one after the other"
    for side in kerbs:
        names = ", ".join(f'"{side}_{name}"' for name in places)
        yield f"{side} = [{names}]"


def _crosswalks(length: float, kerbs: tuple[float, float], crosswalks: Sequence[float]) -> Iterator[str]:
    """Yield the lines of the crosswalks, each with a jaywalk zone to its east."""
    yield "\n# From kerb to kerb. `landing`: the waypoints at both ends. People may jaywalk in the `zone`: from and to,"
    yield "# in metres from the crosswalk's edge along the kerb toward `outer`, the next waypoint."
    ends = [*(place - STRIPES / 2 for place in crosswalks[1:]), length - END]
    for number, (place, end) in enumerate(zip(crosswalks, ends, strict=True), 1):
        outer = str(number + 1) if number < len(crosswalks) else "east"
        zone = min(LONGEST_ZONE, end - place - STRIPES / 2 - 1)
        yield f"\n[crosswalks.crossing_{number}]"
        yield f"area = [{place - STRIPES / 2:g}, {kerbs[0]:g}, {place + STRIPES / 2:g}, {kerbs[1]:g}]"
        yield "sides = ["
        for side in ("south", "north"):
            yield f'    {{ landing = "{side}_{number}", outer = "{side}_{outer}", zone = [1, {zone:g}] }},'
        yield "]"
    yield ""

"""The first check: limits on sizes and numbers, so that the other checks end and fit into memory."""

from __future__ import annotations

from collections.abc import Iterator

from jaxwalk.maps.file import MapFile

LARGEST = 2000.0
"""Largest length or coordinate [m]."""
MOST = {"roads": 50, "sidewalks": 500, "crosswalks": 100, "waypoints": 500, "walkways": 500}
"""Largest number of each part of a map."""
MOST_PLACES, MOST_ROUTES, LONGEST_WALKWAY = 200, 1000, 100
"""Largest number of the car's places, of its routes, and of waypoints that a walkway joins."""
MOST_METRES = 200_000.0
"""Largest value of routes times (width + height), a bound on the length of all routes together [m]."""


def size_faults(file: MapFile) -> list[str]:
    """Return the faults of size and number, one line each; [] if the other checks can run."""
    faults = [
        f"{name}: {len(getattr(file, name))} are too many; a map has at most {most}"
        for name, most in MOST.items()
        if len(getattr(file, name)) > most
    ]
    places = len(file.car.places)
    routes = places * (places - 1) if file.car.routes == "all" else len(file.car.routes)
    if places > MOST_PLACES:
        faults.append(f"car.places: {places} are too many; a map has at most {MOST_PLACES}")
    if routes > MOST_ROUTES:
        faults.append(f"car.routes: {routes:,} are too many; list at most {MOST_ROUTES:,}")
    faults += [
        f"walkways.{name}: joins {len(chain)} waypoints; split it into pieces of at most {LONGEST_WALKWAY}"
        for name, chain in file.walkways.items()
        if len(chain) > LONGEST_WALKWAY
    ]
    faults += [f"{name}: {value:g} m is beyond {LARGEST:g} m; is it in metres?" for name, value in _lengths(file)]
    if not faults and routes * sum(file.size) > MOST_METRES:
        faults.append(f"car.routes: {routes:,} on a map of this size don't fit into memory; list fewer")
    return faults


def _lengths(file: MapFile) -> Iterator[tuple[str, float]]:
    """Yield each part that has a length beyond LARGEST, with the first such length [m]."""
    parts = {"size": file.size, "car.right_turn_radius": (file.car.right_turn_radius,)}
    parts["car.left_turn_radius"] = (file.car.left_turn_radius,)
    parts |= {f"car.places[{number}]": place for number, place in enumerate(file.car.places)}
    parts |= {f"roads.{name}": area for name, area in file.roads.items()}
    parts |= {f"sidewalks.{name}": area for name, area in file.sidewalks.items()}
    parts |= {f"waypoints.{name}": point for name, point in file.waypoints.items()}
    parts |= {f"crosswalks.{name}.area": crosswalk.area for name, crosswalk in file.crosswalks.items()}
    for name, crosswalk in file.crosswalks.items():
        parts |= {f"crosswalks.{name}.sides[{number}].zone": side.zone for number, side in enumerate(crosswalk.sides)}
    for name, values in parts.items():
        too_large = [value for value in values if abs(value) > LARGEST]
        yield from ((name, value) for value in too_large[:1])

"""What a page of `jaxwalk live` is sent: the start of a record (`jaxwalk.viewer.record`), then frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import Any

import numpy as np

from jaxwalk.exports.replays import routes_of
from jaxwalk.maps import MapText, as_network
from jaxwalk.sim import vehicle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.recording import parked_boxes
from jaxwalk.sim.scenario import Scenario
from jaxwalk.viewer.drawn_map import DrawnMap
from jaxwalk.viewer.record import boxes_record, line_record, state_bits

CAR = ("car_x", "car_y", "car_heading", "car_speed", "car_acceleration")
"""A frame's numbers of the car."""


@lru_cache(maxsize=8)
def drawn(text: MapText) -> dict[str, Any]:
    """Return how a map is drawn, as plain numbers. It is kept."""
    return asdict(DrawnMap.of(as_network(text)))


def first_record(street: Street, scenarios: Scenario) -> dict[str, Any]:
    """Return the map, and a record of the only scenario of a batch in which nothing has moved yet."""
    rules = street.world.rules
    goal = [round(float(at[0]), 2) for at in vehicle.goal(street.world, scenarios)]
    nothing: list[int] = []
    people = rules.pedestrians
    lost = {"x": nothing, "y": nothing}
    record = {
        "goal": goal,
        "touched": nothing,
        "tendency": np.round(np.asarray(scenarios.jaywalking_tendency(street.world))[:, 0].astype(float), 2).tolist(),
        "events": nothing,
        "route": line_record(routes_of(street, scenarios)[0]),
        "car": {name: nothing for name in ("x", "y", "heading", "speed", "acceleration")},
        "people": [{"x": nothing, "y": nothing, "state": nothing, "lost": lost} for _ in range(people)],
    }
    boxes = parked_boxes(street.world, scenarios)
    if boxes is not None:
        record["parked"] = boxes_record(boxes[0][~np.isnan(boxes[0, :, 0])])
    if rules.perception:
        record["delay"] = round(rules.delay / rules.dt)
    text = street.maps[int(np.asarray(scenarios.map)[0])]
    return {"record": record, "dt": rules.dt, "map": drawn(text)}


def moment_record(frame: Mapping[str, np.ndarray], known: np.ndarray | None) -> dict[str, Any]:
    """Return one frame of the only episode of a batch.

    Args:
        frame: the moment's columns, ``(episode)`` or ``(ped, episode)``.
        known: who was perceived in the frame before, ``(ped, episode)``; None at the start and without perception.

    Returns:
        ``car``: x, y [m], heading [rad], speed [m/s] and commanded acceleration [m/s2]. ``people``: x, y and the bits
        of the state of each; for who has just been lost from sight also x and y of where they were last seen.
    """
    one = {name: np.asarray(column)[..., 0] for name, column in frame.items()}
    one["car_heading"] = np.arctan2(one["car_sin"], one["car_cos"])
    perceived = one.get("perceived")
    bits = state_bits(one["going"], one["on_roadway"], one["crossing"], perceived)
    people = [
        [round(float(x), 2), round(float(y), 2), int(state)]
        for x, y, state in zip(one["ped_x"], one["ped_y"], bits, strict=True)
    ]
    if known is not None and perceived is not None:
        for ped in np.flatnonzero(np.asarray(known)[..., 0] & ~perceived):
            people[ped] += [round(float(one[name][ped]), 2) for name in ("last_seen_x", "last_seen_y")]
    return {"car": [round(float(one[name]), 3) for name in CAR], "people": people}

"""An episode as OpenSCENARIO XML 1.2: every road user follows its trajectory, point by point, with times.

`jaxwalk.formats.openscenario_script` writes scripted tests.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.opendrive import load_library
from jaxwalk.formats.openscenario_parts import (
    VERSION,
    add_parked,
    at_time,
    begins_at,
    body,
    follows,
    our_properties,
    rear_places,
)
from jaxwalk.formats.paths import Path, paths
from jaxwalk.formats.tracks import CAR, Tracks
from jaxwalk.sim.sim_config import SimConfig


def openscenario(
    tracks: Tracks,
    *,
    name: str,
    road_file: str,
    config: SimConfig,
    parked: Float[np.ndarray, "vehicle column"],
    street: Mapping[str, object] | None = None,
) -> bytes:
    """Return the episode as an OpenSCENARIO document. Raises TracksError if scenariogeneration is missing.

    Args:
        tracks: an episode of the simulator, with all road users in every frame.
        name: the scenario's name.
        road_file: name of the OpenDRIVE file beside it.
        config: gives the car's wheelbase and limits.
        parked: the boxes of parked vehicles (`jaxwalk.maps.parking_slots.SLOT_COLUMNS`).
        street: which street and route it is, for our own reader: ``track`` and ``route``.
    """
    library = load_library()
    xosc = library.xosc
    everybody = paths(tracks)
    end = max(path.t[-1] for path in everybody.values())
    entities, init = xosc.Entities(), xosc.Init()
    board = xosc.StoryBoard(init, at_time(xosc, "end", end, "stop"))
    act = xosc.Act("episode", at_time(xosc, "begin", 0.0, "start"))
    for id, path in everybody.items():
        who = f"{path.type}{id}"
        back = config.wheelbase / 2 if path.type == CAR else 0.0
        entities.add_scenario_object(who, body(xosc, path, config))
        places = rear_places(xosc, path, back)
        init.add_init_action(who, xosc.TeleportAction(places[0]))
        if path.type == CAR and "speed" in tracks.known:
            init.add_init_action(who, begins_at(xosc, float(tracks.known["speed"][tracks.id == id][0])))
        line, at_once = xosc.Polyline(path.t.tolist(), places), at_time(xosc, f"{who} begins", 0.0, "start")
        act.add_maneuver_group(follows(xosc, who, line, at_once, xosc.ReferenceContext.absolute))
    add_parked(xosc, entities, init, parked, config)
    story = xosc.Story("story")
    story.add_act(act)
    board.add_story(story)
    scenario = xosc.Scenario(
        name, "jaxwalk", xosc.ParameterDeclarations(), entities, board, xosc.RoadNetwork(roadfile=road_file),
        xosc.Catalog(), osc_minor_version=VERSION, header_properties=our_properties(xosc, street or {}),
    )  # fmt: skip
    return library.helpers.prettify(scenario.get_element())


def read_openscenario(document: bytes) -> dict[int, Path]:
    """Return the paths of centres in a document that `openscenario` wrote, by id."""
    root, found = ET.fromstring(document), {}
    bodies = {one.get("name", ""): one for one in root.iter("ScenarioObject")}
    for group in root.iter("ManeuverGroup"):
        who = next(group.iter("EntityRef")).get("entityRef", "")
        vertices = [(v.get("time"), v.find("Position/WorldPosition")) for v in group.iter("Vertex")]
        t = np.array([float(time or "nan") for time, _ in vertices])
        x, y, heading = (np.array([float(p.attrib[name]) for _, p in vertices if p is not None]) for name in "xyh")
        centre, size = (next(bodies[who].iter(name)).attrib for name in ("Center", "Dimensions"))
        ahead = float(centre["x"])
        kind = who.rstrip("0123456789")
        found[int(who.removeprefix(kind))] = Path(
            type=kind, t=t, x=x + ahead * np.cos(heading), y=y + ahead * np.sin(heading), heading=heading,
            length=float(size["length"]), width=float(size["width"]),
        )  # fmt: skip
    return found

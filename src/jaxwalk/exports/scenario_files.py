"""Files of one episode of an evaluation for other simulators."""

from __future__ import annotations

import re
from itertools import chain, count
from pathlib import Path

import numpy as np

from jaxwalk.evaluation import replay
from jaxwalk.exports.drawn_episode import network_of_scenario
from jaxwalk.formats.commonroad import commonroad, read_commonroad
from jaxwalk.formats.opendrive import opendrive
from jaxwalk.formats.openscenario import openscenario, read_openscenario
from jaxwalk.formats.openscenario_script import InexpressibleRun, openscenario_script
from jaxwalk.formats.paths import largest_error, paths
from jaxwalk.formats.road_network import road_network
from jaxwalk.formats.tracks import tracks_of
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import as_network
from jaxwalk.scenarios import Scripted, Source
from jaxwalk.scenarios.staging import Case
from jaxwalk.scenarios.xosc.our_properties import street_name
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import FAR_AWAY
from jaxwalk.sim.trajectory import with_people
from jaxwalk.writing import together, write_whole

EPISODE, MAP, COMMONROAD = "episode.xosc", "map.xodr", "commonroad.xml"
"""Names of the files in the folder."""
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_.+]+")
"""What becomes a hyphen in the names of files."""
LONGEST_NAME = 100
"""Most characters of a test's name in that of a file."""


def export_scenario(
    street: Street, policies: Roles[Policy], source: Source, number: int, folder: Path, *, name: str
) -> float:
    """Play a scenario as an evaluation does, and write it as OpenSCENARIO with OpenDRIVE and as CommonRoad.

    Args:
        street: the world.
        policies: who plays each role.
        source: the scenarios.
        number: which of them.
        folder: where to write; files of the same names are replaced.
        name: what the files say they are.

    Returns:
        The largest distance between anybody and its copy in either file, as read back, over all frames [m].

    Raises:
        TracksError: scenariogeneration is missing, or roads can't be made of the street's lanes.
    """
    trajectory = replay(street, policies, source, [number])
    trajectory = with_people(trajectory, trajectory.ped_x[0, 0] != FAR_AWAY)  # only those who are there
    tracks, parked = next(tracks_of(trajectory)), trajectory.parked_in(0)
    network = road_network(network_of_scenario(street, source, number))
    documents = {
        EPISODE: openscenario(
            tracks, name=name, road_file=MAP, config=street.config, parked=parked, street=_place(street, source, number)
        ),
        MAP: opendrive(network, name),
        COMMONROAD: commonroad(tracks, network, name=name, config=street.config, parked=parked),
    }
    original = paths(tracks)
    copies = read_openscenario(documents[EPISODE]), read_commonroad(documents[COMMONROAD])
    folder.mkdir(parents=True, exist_ok=True)
    with together():
        for file, document in documents.items():
            write_whole(folder / file, document)
    return max(largest_error(original, copy) for copy in copies)


def export_tests(source: Scripted, folder: Path) -> tuple[int, list[str]]:
    """Write each run of crash tests as OpenSCENARIO, ``NAME-SPEED.xosc``, with the OpenDRIVE file of their street.

    Where names differ only in what files can't be called, a number follows: ``NAME-SPEED-2.xosc``.

    Returns:
        How many were written, and why others were not.

    Raises:
        TracksError: scenariogeneration is missing, or roads can't be made of the street's lanes.
    """
    documents, refused = {}, []
    for number, case in enumerate(source.cases):
        try:
            document = openscenario_script(source, number, road_file=MAP)
            documents[_file_name(case, {name.casefold() for name in documents})] = document
        except InexpressibleRun as error:
            refused.append(str(error))
    documents[MAP] = opendrive(road_network(as_network(source.street.maps[0])), source.suite.name)
    folder.mkdir(parents=True, exist_ok=True)
    with together():
        for file, document in documents.items():
            write_whole(folder / file, document)
    return len(documents) - 1, refused


def _file_name(case: Case, taken: set[str]) -> str:
    """Return the name of a run's file, which is none of those that are taken, in small letters."""
    name = f"{NOT_IN_NAMES.sub('-', case.name)[:LONGEST_NAME].strip('-') or 'test'}-{case.speed:g}"
    names = chain([f"{name}.xosc"], (f"{name}-{number}.xosc" for number in count(2)))
    return next(one for one in names if one.casefold() not in taken)


def _place(street: Street, source: Source, number: int) -> dict[str, object]:
    """Return the name of a scenario's street, and the number of the car's route there; nothing for unnamed streets."""
    scenarios, _ = source.take(np.array([number]))
    name = street_name(str(street.maps[int(scenarios.map[0])].name))
    return {} if name is None else {"track": name, "route": int(scenarios.route[0])}

"""Pages to open: two drivers in the same three scenarios, the first of which one of them survives."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxwalk.maps import load_network
from jaxwalk.report.watched import Gallery, WatchedEpisode, WatchedIncident
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.walking_paths import Paths
from jaxwalk.viewer.drawn_map import DrawnMap
from jaxwalk.viewer.record import make_records
from jaxwalk.viewer.replay import document, entries
from metrics.scenes import Scene, Walk, trajectory
from viewer.sight import with_sight

PEOPLE = [
    Walk(50.0, 50.0, vy=1.0, crossings=[(22, 50, JAYWALK)], waits=[1], tau=0.9),
    Walk(70.0, 54.0, vx=0.5, tau=0.1),
]
HIT = Scene(40, PEOPLE, x=20.0, touched=[0])
SLOWED = Scene(50, PEOPLE, x=20.0, speed=2.0, acceleration=dict.fromkeys(range(25, 35), -3.0), goal=True)
DRIVERS = {"rash": (HIT, SLOWED, HIT), "careful": (SLOWED, SLOWED, HIT)}
SCENARIOS = [7, 9, 217]


def replay_document(seen=lambda recorded: recorded):
    """What a page of these episodes shows; ``seen`` adds what the car perceives."""
    found = []
    for driver, scenes in DRIVERS.items():
        t = trajectory(*scenes, scenario=SCENARIOS)
        t = seen(_moved(t))
        routes = [np.array([[20.0, 54.0], [60.0, 54.0]])] * len(scenes)
        records = make_records(t, _paths(len(scenes)), routes)
        found += entries(t, records, [0] * len(scenes), driver=driver, pedestrians="always-go", multiplier=0.25)
    return document(found, [load_network("paper")], dt=0.1)


def sighted_document():
    """The same where the car loses pedestrian 1 from 1.0 s to 3.8 s, beside a parked vehicle."""

    def seen(recorded):
        boxes = np.array([[[44.0, 50.6, 1, 0, 2.2, 0.9], [np.nan] * 6]] * len(SCENARIOS))
        return dataclasses.replace(with_sight(recorded, {0: [(10, 38)]}), parked=boxes)

    return replay_document(seen)


def _moved(t):
    """Scenes have their road along y = 0; the map's is 54 m farther north."""
    return dataclasses.replace(t, car_y=t.car_y + 54.0, goal_x=t.goal_x + 60.0, goal_y=t.goal_y + 54.0)


def _paths(episodes):
    """Pedestrian 0 crosses the road and goes on, pedestrian 1 walks east."""
    x, y = np.array([[50.0, 50.0, 50.0], [70.0, 80.0, 90.0]]), np.array([[50.0, 60.0, 70.0], [54.0, 54.0, 54.0]])
    shape = (2, episodes)
    return Paths(
        x=np.broadcast_to(x.T[:, :, None], (3, *shape)),
        y=np.broadcast_to(y.T[:, :, None], (3, *shape)),
        jaywalk=np.broadcast_to(np.array([[True, False], [False, False]])[:, :, None], (2, *shape)),
        arrivals=np.zeros((2, *shape), int),
    )


def incidents():
    """The gallery's list for `replay_document`."""
    common = {"contact": "jaywalk", "moving": True, "ped": 0, "car": "going straight", "side": "from the right"}
    measured = {"speed": 5.0, "risk": 0.2, "ttc": None, "nearest": None}
    hit = {"kind": "collision", "t": 4.0, "avoidable": "driver", **common, **measured}
    missed = common | {"kind": "near miss", "t": 3.0, "avoidable": None, "speed": None, "risk": None, "ttc": 0.4}
    return [
        {"episode": 0, **hit},
        {"episode": 2, **hit, "risk": 0.1, "avoidable": "either"},
        {"episode": 1, **missed, "nearest": 2.0, "contact": "crosswalk"},
        {"episode": 5, **hit, "risk": 0.3},
    ]


def gallery_document():
    """What the gallery of failures shows."""
    return {**replay_document(), "lead": 3.0, "most": 40, "scenarios": 500, "incidents": incidents()}


def watched(document):
    """The typed gallery of a document."""
    episodes = tuple(WatchedEpisode(**one) for one in document["episodes"])
    incidents = tuple(WatchedIncident(**one) for one in document["incidents"])
    maps = tuple(DrawnMap(**one) for one in document["maps"])
    return Gallery(**{**document, "maps": maps, "episodes": episodes, "incidents": incidents})

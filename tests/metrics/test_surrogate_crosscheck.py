"""Surrogate safety beside independent public implementations, each on 1,000 random encounters.

They are not needed to work on jaxwalk: ``pip install -e .[crosscheck]`` brings them, and CI does. *Traffic
Intelligence* (N. Saunier, Polytechnique Montréal) has two-dimensional TTC and PET of discs, defined as here. The SSM
device of *Eclipse SUMO* (DLR) has TTC and DRAC of vehicles on a lane: there a disc of 1.5 m and a vehicle of 1.5 m are
the same.
"""

from __future__ import annotations

import math
import warnings
from xml.etree import ElementTree

import numpy as np
import pytest

from jaxwalk.metrics import ENCOUNTERS, SURROGATES, measure
from jaxwalk.metrics.footprint import required_deceleration, time_to_collision
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from metrics.scenes import DISC, Scene, Walk, trajectory

COUNT = 1000
RADIUS = 1.5


@pytest.fixture(scope="module")
def moving():
    """The module of Traffic Intelligence with moving objects."""
    if not hasattr(np, "NaN"):
        np.NaN = np.nan  # Traffic Intelligence 0.2.10 imports it under the name it had before NumPy 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("trafficintelligence.moving")


@pytest.fixture(scope="module")
def random_encounters():
    """A trajectory of random crossings, at varying speeds, in front of or behind a car; and its rows."""
    rng = np.random.default_rng(0)
    scenes = []
    for _ in range(2 * COUNT):
        place = {"x": rng.uniform(2, 22), "y": rng.uniform(-6, 0)}
        walk = Walk(**place, vx=rng.uniform(-1, 1), vy=rng.uniform(0.5, 2), crossings=[(1, 45, rng.integers(1, 3))])
        scenes.append(Scene(49, [walk], speed=np.clip(rng.uniform(0, 8) + np.cumsum(rng.normal(0, 0.3, 50)), 0, 9)))
    recorded = trajectory(*scenes)
    rows = measure(recorded, config=DISC)
    assert len(rows[ENCOUNTERS].episode) > COUNT
    assert {CROSSWALK, JAYWALK} == set(rows[ENCOUNTERS].type)
    return recorded, rows


def test_time_to_collision_agrees_with_traffic_intelligence(moving):
    """`Point.timeToCollision` in two dimensions; states in touch are left out (there it gives when they will part)."""
    rng = np.random.default_rng(1)
    dx, dy, dvx, dvy = rng.uniform(-12, 12, (4, 2 * COUNT))
    apart = np.flatnonzero(np.hypot(dx, dy) > RADIUS)[:COUNT]
    still = moving.Point(0, 0)

    def theirs(k: int) -> float:
        there, velocity = moving.Point(dx[k], dy[k]), moving.Point(dvx[k], dvy[k])
        ttc = moving.Point.timeToCollision(there, still, velocity, still, RADIUS)
        return math.inf if ttc is None else ttc

    ours = time_to_collision(dx, dy, dvx, dvy, RADIUS)[apart]
    assert len(ours) == COUNT
    assert 50 < np.isfinite(ours).sum() < COUNT
    np.testing.assert_allclose(ours, [theirs(k) for k in apart], rtol=1e-9)


def test_post_encroachment_time_agrees_with_traffic_intelligence(moving, random_encounters):
    """`MovingObject.computePET` of the driven and the walked path; it has no sign, but tells the two instants."""
    recorded, rows = random_encounters

    def walker(number: int, x: np.ndarray, y: np.ndarray, first: int):
        points = [moving.Point(*point) for point in zip(x, y, strict=True)]
        interval = moving.TimeInterval(first, first + len(x) - 1)
        return moving.MovingObject(number, interval, moving.Trajectory.fromPointList(points))

    def theirs(row: int) -> float:
        e, enter, start, end = (getattr(rows[ENCOUNTERS], name)[row] for name in ("episode", "enter", "start", "end"))
        car = walker(1, recorded.car_x[start:50, e], recorded.car_y[start:50, e], start)
        person = walker(2, recorded.ped_x[enter : end + 1, e, 0], recorded.ped_y[enter : end + 1, e, 0], enter)
        pet, car_frame, person_frame = moving.MovingObject.computePET(car, person, RADIUS)
        return math.nan if pet is None else math.copysign(pet, car_frame - person_frame) / 10

    ours = rows[SURROGATES].pet[:COUNT]
    expected = np.array([theirs(row) for row in range(COUNT)])
    assert min((ours > 0).sum(), (ours < 0).sum(), (ours == 0).sum(), np.isnan(ours).sum()) > 20
    np.testing.assert_allclose(ours, expected, rtol=1e-5)


NET = """<net version="1.20">
<location netOffset="0,0" convBoundary="0,0,{x},0" origBoundary="0,0,{x},0" projParameter="!"/>
<edge id="e" from="a" to="b"><lane id="e_0" index="0" speed="50" length="{x}" shape="0,0 {x},0"/></edge>
<junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0"/>
<junction id="b" type="dead_end" x="{x}" y="0" incLanes="e_0" intLanes="" shape="{x},0"/></net>"""
ROUTES = '<routes><vType id="disc" length="1.5" minGap="0" speedDev="0"/><route id="r" edges="e"/>{}</routes>'
VEHICLE = """<vehicle id="{}" type="disc" route="r" depart="0" departPos="{}" departSpeed="{}" insertionChecks="none">
<param key="has.ssm.device" value="{}"/></vehicle>"""
SSM = {"measures": "TTC DRAC", "thresholds": "1e9 0", "range": "60", "trajectories": "true"}


def sumo_log(sumo, folder, ahead, speed, other_speed) -> ElementTree.Element:
    """The log of SUMO's SSM device: pairs of vehicles 200 m apart, ``ahead`` m from front to front [m, m/s]."""
    place = 200.0 * np.arange(len(ahead)) + 50
    cars = [VEHICLE.format(f"car{k}", place[k], speed[k], "true") for k in range(len(ahead))]
    others = [VEHICLE.format(f"ped{k}", place[k] + ahead[k], other_speed[k], "false") for k in range(len(ahead))]
    (folder / "net.xml").write_text(NET.format(x=200 * len(ahead) + 200))
    (folder / "routes.xml").write_text(ROUTES.format("".join(cars + others)))
    options = ["--net-file", folder / "net.xml", "--route-files", folder / "routes.xml", "--step-length", "0.1"]
    options += ["--precision", "9", "--collision.action", "none", "--no-step-log", "--no-warnings"]
    options += [x for name, value in SSM.items() for x in (f"--device.ssm.{name}", value)]
    sumo.start(["sumo", *map(str, options), "--device.ssm.file", str(folder / "ssm.xml")])
    sumo.simulationStep()
    sumo.close()
    return ElementTree.parse(folder / "ssm.xml").getroot()


def test_time_to_collision_and_required_deceleration_agree_with_sumo(tmp_path):
    """SUMO's SSM device while a vehicle nears another on a lane: one dimension, where both definitions are the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sumo = pytest.importorskip("libsumo")
    rng = np.random.default_rng(2)
    ahead, speed, other_speed = rng.uniform((2, 5, 0), (40, 15, 5), (COUNT, 3)).T
    state = ahead, 0.0, other_speed - speed, 0.0, RADIUS
    ttc = time_to_collision(*state)
    ours = {"TTC": ttc, "DRAC": required_deceleration(ttc, np.hypot(*state[2:4]))}
    log = sumo_log(sumo, tmp_path, ahead, speed, other_speed)
    conflicts = {conflict.get("ego"): conflict for conflict in log.iter("conflict")}
    assert len(conflicts) == COUNT
    for name, values in ours.items():
        spans = [conflicts[f"car{k}"].find(f"{name}Span") for k in range(COUNT)]
        theirs = [float(span.get("values").split()[0]) for span in spans]
        np.testing.assert_allclose(values, theirs, rtol=1e-6, atol=1e-8)

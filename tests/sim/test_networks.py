"""Streets that bend or lie at an angle, and many at once: the laws of the world hold there too."""

from __future__ import annotations

from collections import Counter

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import shapely

from jaxwalk import Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.maps import MapText
from jaxwalk.maps.network_file import network_text
from jaxwalk.maps.network_scene import signed_distance
from jaxwalk.sim import vehicle
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from maps.networks import CENTRE, bend, island, turned
from sim.play import ENVIRONMENTS, PEOPLE, STEPS, compiled, draw, play, random_actions, reset

ANGLE = 0.7
NEAR = 0.06
"""The line of a zone is a chord of 2.5 m of its kerb, and people cross it slanted [m]."""


def text(network, name="town.json"):
    return MapText.of(name, network_text(network))


@pytest.fixture(scope="module")
def bent():
    return Street.create([text(bend())])


@pytest.fixture(scope="module")
def bent_scenarios(bent):
    return draw(bent, 3, 0, 0)


@pytest.fixture(scope="module")
def eager(bent, bent_scenarios):
    """Many jaywalks, random drivers, people who wait now and then."""
    return play(with_jaywalk_multiplier(bent, 2.0), bent_scenarios, *random_actions(2))


def inside_of(surface, played):
    """Whether people are on a surface: surely, or perhaps."""
    points = played["x"], played["y"]
    sure, perhaps = surface.buffer(-NEAR), surface.buffer(NEAR)
    shapely.prepare([sure, perhaps])
    return shapely.contains_xy(sure, *points), shapely.contains_xy(perhaps, *points)


def test_people_on_a_bend_are_where_people_may_be(eager):
    surely, perhaps = inside_of(bend().surface("roadway"), eager)
    assert eager["on_roadway"][surely].all()
    assert not eager["on_roadway"][~perhaps].any()
    _, on_foot = inside_of(bend().surface("sidewalk", "crosswalk"), eager)
    assert (on_foot | (eager["crossing"] == JAYWALK)).all()
    surely, perhaps = inside_of(bend().surface("crosswalk"), eager)
    assert not eager["on_crosswalk"][~perhaps].any()
    assert (eager["crossing"][surely & eager["on_roadway"]] == CROSSWALK).all()


def test_jaywalks_on_a_bend_lie_between_the_ends_of_the_zone(eager):
    """The zone's middle begins 3 m and ends 27 m from the crosswalk's middle, of about 5 m a tenth of a radian."""
    entries = eager["on_roadway"][1:] & ~eager["on_roadway"][:-1] & (eager["crossing"][1:] == JAYWALK)
    x, y = eager["x"][1:][entries], eager["y"][1:][entries]
    angle = np.arctan2(y - 45, x + 30)
    assert len(angle) > 500
    assert (angle > -0.5 + 0.06 - 0.02).all()
    assert (angle < -0.5 + 0.54 + 0.02).all()
    for part in np.array_split(np.linspace(-0.42, 0.02, 9), 3):  # it is used everywhere
        assert ((angle > part[0]) & (angle < part[-1])).mean() > 0.1
    radius = np.hypot(y - 45, x + 30)
    assert (np.minimum(np.abs(radius - 46), np.abs(radius - 54)) < 0.21 + NEAR).all()


def test_without_jaywalking_nobody_leaves_the_crosswalk(bent, bent_scenarios):
    played = play(with_jaywalk_multiplier(bent, 0.0), bent_scenarios)
    assert played["on_roadway"].any()
    assert not (played["on_roadway"] & ~played["on_crosswalk"]).any()


def test_nobody_is_faster_and_every_entry_is_announced(eager, bent_scenarios):
    moved = np.hypot(np.diff(eager["x"], axis=0), np.diff(eager["y"], axis=0))
    assert (moved <= 0.1 * (1 + np.asarray(bent_scenarios.traits[1])) + 1e-4).all()
    on = eager["on_roadway"]
    assert eager["at_kerb"][:-1][on[1:] & ~on[:-1]].all()
    assert not (eager["at_kerb"] & on).any()
    assert (eager["crossing"][on] != 0).all()


def test_cars_on_a_bend_stay_on_the_road(eager):
    room = signed_distance(bend().surface("roadway"), np.stack([eager["car_x"], eager["car_y"]], axis=-1))
    assert room.min() > -0.05
    slowed = np.diff(eager["car_speed"], axis=0) < -0.31  # put back onto the road
    assert slowed.sum() > 100
    assert np.abs(room[1:][slowed] - 0.5).max() < 0.3


def steady():
    """Cars at 1.2 m/s along the arcs of the two lanes; people who wait now and then."""
    drive = np.zeros((STEPS, 2, ENVIRONMENTS), np.float32)
    drive[:4, 0] = 1.0
    return drive, random_actions(4)[1]


def test_a_turned_street_gives_the_same_episode(bent, bent_scenarios):
    network, turn = turned(bend(), ANGLE)
    other = Street.create([text(network)])
    drive, go = steady()
    lane = np.asarray(bent_scenarios.route)
    for number, radius in enumerate((52.0, -48.0)):
        drive[:, 1, lane == number] = np.arctan(2 * np.tan(np.arcsin(1.25 / radius))) / 0.52
    one, two = play(bent, bent_scenarios, drive, go), play(other, draw(other, 3, 0, 0), drive, go)
    for x, y in (("x", "y"), ("car_x", "car_y")):
        expected = turn(np.stack([one[x], one[y]], axis=-1).astype(float))
        np.testing.assert_allclose(two[x], expected[..., 0], atol=1e-3)
        np.testing.assert_allclose(two[y], expected[..., 1], atol=1e-3)
    for name in ("crossing", "decisions", "goal", "arrivals", "on_roadway", "on_crosswalk"):
        differ = (one[name] != two[name]).mean()
        assert differ < 1e-4, name  # a step earlier or later, where a kerb is met exactly
    assert one["along"][-1].min() > 50


def test_a_car_off_a_turned_street_is_put_back_within_a_hand(bent, bent_scenarios):
    """At points beside the kerbs: the same place but for the grid, which doesn't turn."""
    network, turn = turned(bend(), ANGLE)
    other = Street.create([text(network)])
    random = np.random.default_rng(0)
    radius, angle = random.uniform(45, 55, (2000, 1)), random.uniform(-0.7, 0.7, (2000, 1))
    points = CENTRE + radius * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    found = [back(street, where) for street, where in ((bent, points), (other, turn(points)))]
    both = found[0][2] & found[1][2]
    exact = CENTRE + (points - CENTRE) / radius * np.clip(radius, 46.5, 53.5)
    one, two = (np.stack(x[:2], axis=1)[both] for x in found)
    assert both.sum() > 300
    assert np.hypot(*(one - exact[both]).T).max() < 0.15
    assert np.hypot(*(two - turn(exact[both])).T).max() < 0.15
    assert np.hypot(*(turn(one) - two).T).max() < 0.3


def back(street, points):
    """Where points are put back to, and which are off the road."""
    first = np.zeros(len(points), np.int32)
    scenario = eqx.tree_at(lambda s: (s.map, s.route), draw(street, 3, 0, 0, 1), (first, first))
    return _back(street.world, scenario, *points.T.astype(np.float32))


@compiled
def _back(world, scenario, x, y):
    return vehicle.onto_road(world, scenario, vehicle.place(world, scenario), x, y)


@pytest.fixture(scope="module")
def sets():
    """Two sets of three streets, of the same sizes but for rounding."""
    angles = ((0.0, 0.3, 0.6), (0.05, 0.25, 0.6))
    return [Street.create([text(turned(bend(), x)[0], f"{x}.json") for x in row]) for row in angles]


def test_another_set_of_streets_compiles_nothing(sets):
    traces = Counter()

    @jax.jit
    def episode(street, key):
        traces["episode"] += 1
        scenario = street.draw(key)
        actions = {"driver": jnp.array([1.0, 0.1]), "pedestrian": jnp.ones(PEOPLE, jnp.int32)}
        return scenario, street.step(scenario, street.reset(scenario), actions)[0]

    chosen = {int(episode(street, jax.random.key(k))[0].map) for k in range(12) for street in sets}
    assert traces["episode"] == 1
    assert chosen == {0, 1, 2}
    assert [x.name for x in sets[1].maps] == ["0.05.json", "0.25.json", "0.6.json"]


def test_a_scenario_plays_on_the_street_that_it_names(sets):
    scenarios = draw(sets[0], 1, 0, 0)
    start = reset(sets[0], scenarios)
    which = np.asarray(scenarios.map)
    assert np.bincount(which, minlength=3).min() > 60
    for number, angle in enumerate((0.0, 0.3, 0.6)):
        network, _ = turned(bend(), angle)
        here = which == number
        points = np.stack([start.vehicle.x, start.vehicle.y], axis=-1)[here]
        assert signed_distance(network.surface("roadway"), points).min() > 1.9
        people = np.stack([start.pedestrian.x, start.pedestrian.y], axis=-1)[:, here]
        assert signed_distance(network.surface("sidewalk"), people).min() > 0.4


@pytest.mark.long
def test_people_wait_on_an_island_off_the_roadway():
    """A crossing over an island is one crossing, decided once, with two ways over a roadway."""
    street = Street.create([text(island())])
    played = play(street, draw(street, 5, 0, 0))
    surely, perhaps = inside_of(island().surface("roadway"), played)
    assert played["on_roadway"][surely].all()
    assert not played["on_roadway"][~perhaps].any()
    _, on_island = inside_of(island().surface("island"), played)
    assert on_island.any()
    assert not played["on_roadway"][on_island & ~perhaps].any()
    entries, decisions = (played["on_roadway"][1:] & ~played["on_roadway"][:-1]).sum(axis=0), played["decisions"][-1]
    assert (entries <= 2 * decisions).all()
    assert (entries >= 2 * decisions - 2).all()
    assert decisions.mean() > 1
    assert played["at_kerb"][:-1][played["on_roadway"][1:] & ~played["on_roadway"][:-1]].all()
    assert not (played["crossing"] == JAYWALK).any()  # it has no zone

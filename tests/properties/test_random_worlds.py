"""What holds whatever anybody does: any actions, in any scenario, for a whole episode."""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from jaxwalk.sim.crossing_kind import CROSSWALK
from sim.maps import rectangles
from sim.play import ENVIRONMENTS, PEOPLE, STEPS, inside, play

few = settings(
    max_examples=6, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip


@st.composite
def behaviours(draw):
    """Actions for all: held for a step or for seconds, extreme or mild, people hasty or hesitant."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    held = draw(st.sampled_from([1, 5, 20, 100]))
    size = draw(st.sampled_from([0.3, 1.0, 5.0]))
    bias = draw(st.floats(-0.5, 1.0))
    eagerness = draw(st.sampled_from([0.0, 0.3, 0.9, 1.0]))
    blocks = -(-STEPS // held)
    drive = size * random.uniform(-1, 1, (blocks, 2, ENVIRONMENTS))
    drive[:, 0] += bias
    go = random.random((blocks, PEOPLE, ENVIRONMENTS)) < eagerness
    drive, go = (np.repeat(drawn, held, axis=0)[:STEPS] for drawn in (drive, go))
    return drive.astype(np.float32), go.astype(np.int32)


@few
@given(behaviours())
def test_the_laws_of_the_world(street, scenarios, behaviour):
    drive, go = behaviour
    played = play(street, scenarios, drive, go)
    for name, x in played.items():
        assert np.isfinite(x).all(), name

    roads, walks, crosswalks = map(rectangles, ("roads", "sidewalks", "crosswalks"))
    x, y, on = played["x"], played["y"], played["on_roadway"]
    by_crosswalk = played["crossing"] == CROSSWALK

    # The car: on the road, in its bounds, no farther than its speed (but for being put back onto the road).
    assert inside(roads, played["car_x"], played["car_y"], margin=-1e-4).all()
    assert played["car_speed"].min() >= 0
    assert played["car_speed"].max() <= 8.33 + 1e-5
    assert np.abs(np.diff(played["car_speed"], axis=0)).max() < 8.33
    np.testing.assert_allclose(np.hypot(played["car_cos"], played["car_sin"]), 1, atol=1e-5)
    moved = np.hypot(np.diff(played["car_x"], axis=0), np.diff(played["car_y"], axis=0))
    assert moved.max() < 0.833 + 0.833 + 0.5
    assert np.abs(np.diff(played["along"], axis=0)).max() <= 1 + 1e-4

    # People: where they may be, at their speed; the decision is the geometry; the kerb comes before the roadway.
    assert (inside(walks, x, y, margin=-1e-3) | inside(roads, x, y, margin=-1e-3)).all()
    assert (inside(crosswalks, x, y, margin=-1e-3) | ~(on & by_crosswalk)).all()
    assert not (inside(crosswalks, x, y, margin=1e-3) & on & ~by_crosswalk).any()
    stride = 0.1 * (1 + np.asarray(scenarios.traits[1]))
    walked = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0))
    assert (walked <= stride * go + 1e-4).all()
    assert (walked[go == 0] == 0).all()
    assert played["at_kerb"][:-1][on[1:] & ~on[:-1]].all()
    decided = np.diff(played["decisions"], axis=0)
    assert decided.min() >= 0
    assert decided.max() <= 1
    kept = (decided == 0) & (np.diff(played["crossing"], axis=0) != 0)
    assert (played["crossing"][1:][kept] == 0).all()
    assert (np.diff(played["step"], axis=0) == 1).all()

"""Episodes that begin where others have ended are the same as in a batch of their own."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, UInt32

from jaxwalk.acting import role_key, step_key
from jaxwalk.evaluation import ActionError, continuous, play
from jaxwalk.evaluation.continuous import Batch, played
from jaxwalk.policies import RouteFollower
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.suites import SUITES
from jaxwalk.sim.trajectory import AXES, part_of

SIZE = 16
SHORT = 110
"""A horizon at which some episodes time out, others end soon [steps]."""


def batches(source, count):
    for first in range(0, count, SIZE):
        numbers = (first + np.arange(SIZE)) % count
        yield Batch(numbers, *source.take(numbers), min(SIZE, count - first))


def assert_as_alone(street, policies, source, count):
    """Compare with every batch played by itself."""
    found = list(played(street, policies, batches(source, count)))
    assert [batch.numbers[0] for batch, _ in found] == list(range(0, count, SIZE))
    for batch, trajectory in found:
        alone = play(street, policies, batch.scenarios, batch.keys, numbers=batch.numbers)
        assert trajectory.length.shape == (batch.count,)
        assert len(trajectory.car_x) == trajectory.length.max() + 1
        expected = part_of(alone, frames=len(trajectory.car_x), episodes=slice(batch.count))
        for name in AXES:
            np.testing.assert_array_equal(getattr(trajectory, name), getattr(expected, name), err_msg=name)
    return found


@pytest.fixture(scope="module")
def short():
    return Street.create(config=SimConfig(horizon=SHORT))


def test_episodes_are_those_of_a_batch_alone(short, driver, undecided):
    policies = {"driver": driver, "pedestrian": undecided}
    found = assert_as_alone(short, policies, Drawn(short, 5, 88), 88)
    lengths = np.concatenate([trajectory.length for _, trajectory in found])
    assert lengths.min() < SHORT == lengths.max()


@pytest.mark.parametrize(
    ("suite", "name"),
    [
        ("paper", "fuzzy-safety+predictive"),
        pytest.param("blind-corner", "co-trained+cbf", marks=pytest.mark.long),
        pytest.param("blind-corner", "careful-human+predictive-steady", marks=pytest.mark.long),
        pytest.param("town", "belief-planner", marks=pytest.mark.long),
        pytest.param("paper", "co-trained+rss", marks=pytest.mark.long),
    ],
)
def test_so_are_those_of_drivers_with_shields_and_memories(suite, name):
    street = world_of([name], SUITES[suite])
    policies = {
        "driver": contestant(street, "driver", name),
        "pedestrian": contestant(street, "pedestrian", "always-go"),
    }
    assert_as_alone(street, policies, Drawn(street, 74, 40), 40)


def test_columns_do_not_wait_for_the_longest_episode(short, driver, undecided, monkeypatch):
    blocks = []

    def counted(*arguments):
        blocks.append(1)
        return play_block(*arguments)

    play_block = continuous.play_block
    monkeypatch.setattr(continuous, "play_block", counted)
    policies, count = {"driver": driver, "pedestrian": undecided}, 20 * SIZE
    found = [trajectory for _, trajectory in played(short, policies, batches(Drawn(short, 5, count), count))]
    needed = sum(-(-trajectory.length // continuous.BLOCK).sum() for trajectory in found)
    by_batch = sum(-(-trajectory.length.max() // continuous.BLOCK) for trajectory in found)
    longest = -(-SHORT // continuous.BLOCK)
    assert len(blocks) <= needed / SIZE + longest  # no column is empty until the last episodes have begun
    assert len(blocks) < 0.8 * by_batch


class BreaksAt(RouteFollower):
    """Steers beyond its space in the step of the scenario that has this key."""

    key: UInt32[Array, "2"] = eqx.field(kw_only=True)

    def act(self, key, memory, observation):
        action, memory = super().act(key, memory, observation)
        broken = (jax.random.key_data(key) == self.key).all(axis=-1)
        return jnp.where(broken, 1.5, action), memory


def test_a_broken_driver_is_told_after_the_batches_before(short, undecided):
    source = Drawn(short, 5, 3 * SIZE)
    _, keys = source.take(np.arange(3 * SIZE))
    key = role_key(step_key(keys[20], jnp.int32(12)), list(short.roles).index("driver"))
    policies = {"driver": BreaksAt(key=jax.random.key_data(key)), "pedestrian": undecided}
    given = []
    with pytest.raises(ActionError, match=r"\[1.5 1.5\], .* \(scenario 20, step 12\)"):
        given.extend(batch.numbers[0] for batch, _ in played(short, policies, batches(source, 3 * SIZE)))
    assert given == [0]

"""What the learner needs of a rollout."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.acting import fresh_memory
from jaxwalk.learning.casting import learning_cast, whole
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.experience import recording_act
from jaxwalk.learning.mappo import init
from jaxwalk.rollout import RESTART_EVERY, rollout
from learning import games
from pytrees import as_numpy

ROLE = RoleConfig(actor_hidden=(4,), critic_hidden=(4,))
CONFIG = TrainConfig(roles={"driver": ROLE, "pedestrian": ROLE}, environments=3, steps=8 * RESTART_EVERY)


@eqx.filter_jit
def played(game, learner):
    """When what the driver saw was, whether an episode ended then, and whether the step counts."""
    shard = whole(CONFIG)
    cast = learning_cast(game, shard, learner.actors, learner.early, learner.others)
    act, memory = recording_act(game, shard, cast), fresh_memory(game, cast, (CONFIG.environments,))
    _, found = rollout(game, act, learner.stream, CONFIG.steps, fresh_memory=memory)
    return found.record.views["driver"]["paper"][:, 1], found.outcome.ended, found.valid


@pytest.mark.parametrize("length", [1, 3, RESTART_EVERY - 1, RESTART_EVERY, RESTART_EVERY + 1, 2 * RESTART_EVERY])
def test_the_step_after_an_episodes_last_shows_its_final_state_and_does_not_count(length):
    game = games.game("bandit", length=length, timeout=True)
    time, ended, valid = as_numpy(played(game, init(game, CONFIG, jax.random.key(0))))
    last = (ended & valid)[:-1]
    assert last.any()
    np.testing.assert_array_equal(time[1:][last], length)
    assert not valid[1:][last].any()

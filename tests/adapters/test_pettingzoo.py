"""The street as PettingZoo's: its own tests, and who ends how."""

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from jaxwalk.adapters.pettingzoo import StreetParallelEnv
from jaxwalk.adapters.players import AdapterError
from jaxwalk.sim.sim_config import SimConfig

RULES = SimConfig(horizon=120)


def make(**options):
    return StreetParallelEnv(config=RULES, **options)


@pytest.fixture(scope="module")
def env():
    return make(render_mode="rgb_array")


def test_pettingzoo_finds_nothing_wrong(env):
    assert parallel_api_test(env, num_cycles=130) is None


def test_pettingzoo_finds_seeds_to_mean_what_they_say():
    assert parallel_seed_test(make, num_cycles=40) is None


def test_only_those_who_collided_have_terminated(env):
    """Full throttle among people who always go: in this scenario somebody is hit early."""
    go = {name: 1 for name in env.possible_agents} | {"driver": np.array([1, 0], np.float32)}
    env.reset(seed=0, options={"scenario": 25})
    while env.agents:
        observations, rewards, terminated, truncated, infos = env.step(go)
    assert infos["driver"]["collision"]
    hit = [name for name, over in terminated.items() if over]
    assert hit[0] == "driver" and len(hit) >= 2
    assert all(truncated[name] != terminated[name] for name in env.possible_agents)
    for name in env.possible_agents:
        assert observations[name] in env.observation_space(name)
        paid = infos[name]["rewards"]
        assert rewards[name] == pytest.approx(sum(paid.values()), abs=1e-4)
        weight = -150 if name == "driver" else -100
        assert paid["collision"] == (weight if name in hit else 0)
    with pytest.raises(AdapterError, match="the episode is over: call reset"):
        env.step(go)


def test_pictures_are_of_the_episode(env):
    env.reset(seed=1)
    before = env.render()
    env.step({name: env.action_space(name).sample() for name in env.agents})
    assert before.shape == env.render().shape and before.dtype == np.uint8
    assert make().render() is None


def test_impossible_options_are_named():
    with pytest.raises(AdapterError, match="render_mode must be None or 'rgb_array', not 'ascii'"):
        make(render_mode="ascii")


def test_wrong_actions_are_named(env):
    env.reset(seed=1)
    actions = {name: env.action_space(name).sample() for name in env.agents}
    with pytest.raises(AdapterError, match="no action for pedestrian_3: every agent acts at every step"):
        env.step({name: action for name, action in actions.items() if name != "pedestrian_3"})
    with pytest.raises(AdapterError, match="the action of driver has a number that is not finite"):
        env.step(actions | {"driver": np.array([np.nan, 0], np.float32)})
    with pytest.raises(AdapterError, match="the driver gives 2 numbers"):
        env.step(actions | {"driver": np.zeros(3, np.float32)})
    with pytest.raises(AdapterError, match=r"a pedestrian's action is not an integer in \[0, 2\)"):
        env.step(actions | {"pedestrian_2": 2})

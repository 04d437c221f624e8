"""The streets as Stable-Baselines3's vector environment: its own checks, beside Gymnasium's, ends, a short training."""

import gymnasium
import numpy as np
import pytest

from jaxwalk.adapters.gymnasium import StreetVectorEnv
from jaxwalk.adapters.players import AdapterError
from jaxwalk.sim.sim_config import SimConfig

OPTIONS = {"config": SimConfig(horizon=120), "pedestrians": "learned"}
FULL_THROTTLE, BRAKE = np.array([1, 0], np.float32), np.array([-1, 0], np.float32)


@pytest.fixture(scope="module")
def make():
    """The vector environment's class, where Stable-Baselines3 is."""
    pytest.importorskip("stable_baselines3")
    from jaxwalk.adapters.stable_baselines3 import StreetVecEnv

    return StreetVecEnv


@pytest.fixture(scope="module")
def streets(make):
    return make(3, **OPTIONS)


def test_it_steps_as_gymnasiums_vector_environment_does(streets):
    beside = StreetVectorEnv(3, autoreset_mode="SameStep", costs=(), **OPTIONS)
    streets.seed(5)
    assert np.array_equal(streets.reset(), beside.reset(seed=5)[0])
    random, ended = np.random.default_rng(0), 0
    for _ in range(150):
        actions = np.clip(random.uniform(-1, 1, (3, 2)) * (1, 0.1) + (0.6, 0), -1, 1).astype(np.float32)
        seen, rewards, dones, infos = streets.step(actions)
        theirs, their_rewards, terminated, truncated, info = beside.step(actions)
        assert np.array_equal(seen, theirs) and np.array_equal(dones, terminated | truncated)
        assert rewards.dtype == np.float32 and np.allclose(rewards, their_rewards)
        for place in np.flatnonzero(dones):
            assert np.array_equal(infos[place]["terminal_observation"], info["final_obs"][place])
            assert infos[place]["TimeLimit.truncated"] == truncated[place] == infos[place]["timeout"]
            assert infos[place]["is_success"] == info["final_info"]["goal"][place]
        assert [infos[place] for place in np.flatnonzero(~dones)] == [{}] * int((~dones).sum())
        ended += int(dones.sum())
    assert ended >= 3


def test_seeds_and_scenarios_are_those_of_the_other_adapters(streets):
    streets.seed(7)
    streets.set_options({"scenario": 4})
    first = streets.reset()
    expected, _ = StreetVectorEnv(3, **OPTIONS).reset(seed=7, options={"scenario": 4})
    assert np.array_equal(first, expected)
    assert not np.array_equal(streets.reset(), first)  # without a seed: the next episodes


def test_options_are_the_same_for_all_streets(streets):
    streets.set_options([{"scenario": 5}, {"scenario": 9}, {}])
    with pytest.raises(AdapterError, match="options can't differ: the streets are one environment"):
        streets.reset()
    streets.set_options({})


def test_costs_are_in_each_info_if_they_are_asked_for(make):
    streets = make(3, costs=("critical_time",), **OPTIONS)
    streets.reset()
    *_, infos = streets.step(np.tile(BRAKE, (3, 1)))
    assert [info["cost"] for info in infos] == [0.0] * 3


def test_nothing_is_done_to_single_streets(streets):
    assert streets.get_attr("render_mode", [0, 2]) == [None, None]
    assert streets.env_is_wrapped(gymnasium.Wrapper) == [False] * 3
    with pytest.raises(AttributeError):
        streets.get_attr("lidar")
    with pytest.raises(AdapterError, match="seat can't be set: the streets are one environment"):
        streets.set_attr("seat", None)
    with pytest.raises(AdapterError, match="render can't be called on single streets"):
        streets.env_method("render")


@pytest.mark.parametrize("kind", ["PPO", "SAC"])
def test_agents_train_on_it(streets, kind):
    import stable_baselines3

    small = {"PPO": {"n_steps": 8, "batch_size": 12}, "SAC": {"learning_starts": 6, "buffer_size": 100}}[kind]
    agent = getattr(stable_baselines3, kind)("MlpPolicy", streets, seed=0, device="cpu", **small)
    agent.learn(24)
    assert agent.num_timesteps >= 24

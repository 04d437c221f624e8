"""The street as Gymnasium's: its own checks, seeds, ends, the vector environment beside single ones, memory."""

import gymnasium
import jax
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import jaxwalk.adapters.gymnasium
from jaxwalk import Street
from jaxwalk.adapters import seat
from jaxwalk.adapters.gymnasium import StreetEnv
from jaxwalk.adapters.players import AdapterError, player
from jaxwalk.evaluation import play
from jaxwalk.policies import AlwaysGo, ConstantSpeed
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import Observation
from jaxwalk.sim.sim_config import SimConfig

gymnasium.register_envs(jaxwalk.adapters.gymnasium)

ID = "jaxwalk/Street-v0"
RULES = SimConfig(horizon=120)
FULL_THROTTLE, BRAKE = np.array([1, 0], np.float32), np.array([-1, 0], np.float32)


def make(**options):
    return gymnasium.make(ID, **{"config": RULES, "pedestrians": "learned", **options}).unwrapped


def make_many(count=3, **options):
    return gymnasium.make_vec(ID, num_envs=count, **{"config": RULES, "pedestrians": "learned", **options})


@pytest.fixture(scope="module")
def env():
    return make(render_mode="rgb_array")


COSTS = ("contact", "impact_speed")


@pytest.fixture(scope="module")
def three():
    return make_many(costs=COSTS)


def test_gymnasium_finds_nothing_wrong(env):
    assert check_env(env) is None


def test_the_same_seed_plays_the_same_episodes_and_another_seed_others(env):
    first, _ = env.reset(seed=3)
    second, _ = env.reset()
    assert not np.array_equal(first, second)
    env.step(FULL_THROTTLE)
    again, _ = env.reset(seed=3)
    next_again, _ = env.reset()
    assert np.array_equal(first, again) and np.array_equal(second, next_again)
    other, _ = env.reset(seed=4)
    assert not np.array_equal(first, other)


def test_a_car_that_stands_runs_out_of_time(env):
    env.reset(seed=0, options={"scenario": 5})
    ends = []
    for _ in range(RULES.horizon):
        *_, terminated, truncated, info = env.step(BRAKE)
        ends.append((terminated, truncated))
        if terminated or truncated:
            break
    assert ends == [(False, False)] * (RULES.horizon - 1) + [(False, True)]
    assert (info["goal"], info["collision"], info["timeout"]) == (False, False, True)
    with pytest.raises(AdapterError, match="the episode is over: call reset"):
        env.step(BRAKE)


def test_a_reward_is_the_sum_of_its_terms(env):
    env.reset(seed=0)
    for _ in range(5):
        _, reward, _, _, info = env.step(FULL_THROTTLE)
        assert reward == pytest.approx(sum(info["rewards"].values()), abs=1e-5)
    assert info["rewards"]["progress"] > 0 and info["rewards"]["time"] == pytest.approx(-0.06)


def test_a_contact_costs_1_in_its_step_and_nothing_before_it(env):
    """A blind car: scenario by scenario, until it hits somebody and until it arrives."""
    ends = set()
    for scenario in range(24):
        env.reset(seed=7, options={"scenario": scenario})
        costs, over = [], False
        while not over:
            *_, terminated, truncated, info = env.step(FULL_THROTTLE)
            costs.append(info["cost"])
            over = terminated or truncated
            assert info["costs"] == {"contact": info["cost"]}
        assert costs == [0.0] * (len(costs) - 1) + [float(info["collision"])]
        ends.add(info["collision"])
        if len(ends) == 2:
            break
    assert ends == {True, False}


def test_the_cost_is_the_sum_of_the_costs_asked_for(three):
    three.reset(seed=7)
    speeds = set()
    while not speeds:
        *_, info = three.step(np.tile(FULL_THROTTLE, (3, 1)))
        if not info:  # all of them began an episode
            continue
        hit = info["_cost"] & info["collision"]
        np.testing.assert_array_equal(info["costs"]["contact"], hit)
        np.testing.assert_allclose(info["cost"], info["costs"]["contact"] + info["costs"]["impact_speed"])
        speeds |= set(info["costs"]["impact_speed"][hit].tolist())
    assert all(0 < speed <= RULES.max_speed + 1e-4 for speed in speeds)


def test_pictures_show_the_episode_as_it_goes(env):
    env.reset(seed=0)
    before = env.render()
    for _ in range(20):
        env.step(FULL_THROTTLE)
    after = env.render()
    assert before.shape == after.shape and before.shape[2] == 3 and before.dtype == np.uint8
    assert 0 < (before != after).any(axis=2).mean() < 0.2  # what moves, not the ground
    assert make().render() is None


@pytest.mark.long
def test_scenarios_are_those_of_an_evaluation(three):
    """With the same chances for people who decide at random: outcomes and their times are the same."""
    street, count = Street.create(config=RULES), 24
    scenarios, keys = Drawn(street, 7).take(np.arange(count))
    native = play(
        street,
        {"driver": ConstantSpeed(throttle=1.0), "pedestrian": player("pedestrian", "learned", street.config)},
        scenarios,
        keys,
    )
    steps, collided = np.zeros(count, int), np.zeros(count, bool)
    for first in range(0, count, 3):
        part = slice(first, first + 3)
        three.reset(seed=7, options={"scenario": first})
        playing = np.ones(3, bool)
        while playing.any():
            _, _, terminated, truncated, info = three.step(np.tile(FULL_THROTTLE, (3, 1)))
            steps[part] += playing
            ended = playing & (terminated | truncated)
            collided[part] |= ended & info.get("collision", False)
            playing &= ~ended
    assert 0 < native.collision.sum() < count
    assert collided.tolist() == native.collision.tolist()
    assert steps.tolist() == native.length.tolist()


@pytest.mark.long
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_many_streets_are_as_gymnasium_would_step_single_ones(mode):
    many = make_many(autoreset_mode=mode)
    singles = SyncVectorEnv([make] * 3, autoreset_mode=mode)
    assert many.metadata["autoreset_mode"] == mode
    assert many.observation_space == singles.observation_space and many.action_space == singles.action_space
    assert data_equivalence(many.reset(seed=[5, 6, 7]), singles.reset(seed=[5, 6, 7]))
    random, ended = np.random.default_rng(0), 0
    for step in range(260):
        actions = np.clip(random.uniform(-1, 1, (3, 2)) * (1, 0.1) + (0.6, 0), -1, 1).astype(np.float32)
        ours, theirs = many.step(actions), singles.step(actions)
        assert data_equivalence(ours, theirs), f"step {step}"
        ended += int((ours[2] | ours[3]).sum())
    assert ended >= 6


def test_the_streets_of_a_seed_differ_and_no_two_seeds_share_one(three):
    zero, _ = three.reset(seed=0)
    one, _ = three.reset(seed=1)
    again, _ = three.reset(seed=0)
    assert np.array_equal(zero, again)
    rows = {row.tobytes() for row in np.concatenate([zero, one])}
    assert len(rows) == 6


def test_a_step_is_compiled_once_also_for_an_equal_environment(three):
    three.reset(seed=0)
    three.step(np.zeros((3, 2), np.float32))
    before = seat._step._cache_size()
    equal = make_many(costs=COSTS)
    equal.reset(seed=9)
    for envs in (three, equal, three):
        envs.step(np.zeros((3, 2), np.float32))
    assert seat._step._cache_size() == before


@pytest.mark.long
def test_a_long_loop_leaves_nothing_behind(env):
    live = []
    env.reset(seed=0)
    for step in range(600):
        *_, terminated, truncated, _ = env.step(FULL_THROTTLE if step % 3 else BRAKE)
        if terminated or truncated:
            env.reset()
        if step in (199, 399, 599):
            live.append(len(jax.live_arrays()))
    assert live[0] == live[1] == live[2]


def test_what_was_returned_does_not_change_later(three):
    kept, _ = three.reset(seed=0)
    copy = kept.copy()
    for _ in range(3):
        observation, *_ = three.step(np.tile(FULL_THROTTLE, (3, 1)))
    assert np.array_equal(kept, copy) and not np.array_equal(observation, copy)
    observation[:] = 0  # and is the caller's own
    assert three.step(np.tile(FULL_THROTTLE, (3, 1)))[0].any()


class Statues:
    """Pedestrians who never move: a plain object, no pytree."""

    view = Observation("pedestrian", "paper")

    def init(self, agents, batch):
        return None

    def act(self, key, memory, observation):
        return 0 * observation[0].astype(int), memory


@pytest.mark.long
def test_a_population_may_be_any_object_that_is_a_policy():
    envs = make_many(pedestrians=Statues(), observation="paper", reward={"time": 1.0})
    first, _ = envs.reset(seed=0)
    for _ in range(8):
        observation, reward, *_ = envs.step(np.tile(BRAKE, (3, 1)))
    assert np.array_equal(first, observation)  # nobody moved
    assert reward.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pedestrians": "ghosts"}, "ghosts: no pedestrian of that name .*always-go"),
        ({"observation": "lidar"}, "no observation set 'lidar' for the driver"),
        ({"reward": "generous"}, "no recipe 'generous' to pay the driver by; there are: fast, paper"),
        ({"reward": {"luck": 1.0}}, "rewards.driver.luck is no reward term"),
        ({"costs": ("noise",)}, "costs.driver.noise is no cost; there are: contact, impact_speed, critical_time"),
        ({"jaywalk_multiplier": -1.0}, "jaywalk_multiplier must be a finite number of 0 or more"),
    ],
)
def test_impossible_options_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        make(**options)


def test_impossible_numbers_and_pictures_are_named():
    with pytest.raises(AdapterError, match="the number of environments must be at least 1, not 0"):
        make_many(0)
    with pytest.raises(AdapterError, match="render_mode must be None or 'rgb_array', not 'ascii'"):
        StreetEnv(render_mode="ascii")


def test_impossible_actions_and_seeds_are_named(three):
    with pytest.raises(AdapterError, match="call reset first"):
        make_many().step(np.zeros((3, 2), np.float32))
    three.reset(seed=0)
    with pytest.raises(AdapterError, match=r"\(3, 2\) numbers, not \(2,\)"):
        three.step(np.zeros(2, np.float32))
    with pytest.raises(AdapterError, match="not finite"):
        three.step(np.full((3, 2), np.nan, np.float32))
    with pytest.raises(AdapterError, match="seed must be 0 or more and below 4294967296"):
        three.reset(seed=2**32)
    with pytest.raises(AdapterError, match="3 environments need as many seeds, not 2"):
        three.reset(seed=[1, 2])
    with pytest.raises(AdapterError, match="scenario must be 0 or more"):
        three.reset(seed=0, options={"scenario": -1})
    with pytest.raises(AdapterError, match="NextStep or SameStep, not Disabled"):
        make_many(autoreset_mode="Disabled")


class Broken(AlwaysGo):
    """People who choose what is no choice."""

    def act(self, key, memory, observation):
        go, memory = super().act(key, memory, observation)
        return -go, memory


def test_a_broken_population_is_said():
    env = make(pedestrians=Broken())
    env.reset(seed=0)
    with pytest.raises(
        AdapterError, match=r"pedestrians: an action isn't in its space \(environment 0\); the policy is"
    ):
        env.step(FULL_THROTTLE)

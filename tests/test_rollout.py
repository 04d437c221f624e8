"""Rollouts: when episodes end, idle and begin again, and that it doesn't matter how the time is divided."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete, Environment, Moment, Outcome, RoleSpec
from jaxwalk.rollout import (
    EVALUATION,
    RESTART_EVERY,
    SCENARIO_KEYS,
    TRAINING,
    draw_batch,
    environment_keys,
    rollout,
    seed_key,
    start,
    waiting,
)


@dataclass(frozen=True)
class Time:
    agents: tuple[int, ...]
    name: str = "time"

    def __call__(self, moment):
        time = moment.state.reshape(1, *(1,) * len(self.agents), *moment.state.shape).astype(jnp.float32)
        return jnp.broadcast_to(time, (1, *self.agents, *moment.state.shape))


class Clock(eqx.Module):
    """A game that only counts: an episode takes as many steps as its scenario says; the state is the steps taken."""

    @property
    def roles(self):
        return {"driver": RoleSpec((), Box(1)), "pedestrian": RoleSpec((2,), Discrete(2))}

    def draw(self, key):
        length, word = jax.random.split(key)
        return {"length": jax.random.randint(length, (), 2, 20), "word": jax.random.randint(word, (), 0, 2**30)}

    def reset(self, scenario):
        return jnp.zeros_like(scenario["length"])

    def view(self, role, name):
        if name != "time":
            raise ValueError(f"no view {name}")
        return Time(self.roles[role].agents)

    def observe(self, scenario, state, view):
        return view(Moment(None, scenario, state))

    def unhidden(self, scenario, state):
        return state

    def global_state(self, scenario, state):
        return state[None].astype(jnp.float32)

    def step(self, scenario, state, actions):
        state = state + 1
        over = state == scenario["length"]
        people = jnp.broadcast_to(over[None], (2, *over.shape))
        rewards = {"driver": {"action": actions["driver"][0]}, "pedestrian": {}}
        terminated = {"driver": over, "pedestrian": people}
        truncated = {"driver": over & False, "pedestrian": people & False}
        return state, Outcome(rewards, terminated, truncated, over, {"state": state})


def act(key, scenario, state, memory):
    """Acts at random; remembers how often it acted in this episode; records everything."""
    drive = jax.vmap(lambda k: jax.random.uniform(k, (1,)), out_axes=-1)(key)
    record = {"word": scenario["word"], "state": state, "memory": memory, "action": drive[0]}
    return {"driver": drive, "pedestrian": jnp.ones((2, *state.shape), jnp.int32)}, memory + 1, record


@partial(jax.jit, static_argnums=(1, 2, 3))
def played(key, environments, divided, begin=start):
    """Every step of a stream, played in rollouts of the given lengths."""
    fresh = jnp.zeros(environments, jnp.int32)
    stream = begin(Clock(), environment_keys(key, 0, environments), fresh)
    parts = []
    for steps in divided:
        stream, recorded = rollout(Clock(), act, stream, steps, fresh_memory=fresh)
        parts.append(recorded)
    return stream, jax.tree.map(lambda *each: jnp.concatenate(each), *parts)


@pytest.fixture(scope="module")
def key():
    return seed_key(3, TRAINING)


@pytest.fixture(scope="module")
def whole(key):
    return played(key, 24, (128,))


def assert_same(a, b):
    for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True):
        if jnp.issubdtype(x.dtype, jax.dtypes.prng_key):
            x, y = jax.random.key_data(x), jax.random.key_data(y)
        np.testing.assert_array_equal(x, y)


def test_the_clock_is_an_environment():
    assert isinstance(Clock(), Environment)


@pytest.mark.parametrize("divided", [(64, 64), (8, 48, 72)])
def test_how_the_time_is_divided_makes_no_difference(key, whole, divided):
    assert all(steps % RESTART_EVERY == 0 for steps in divided)
    assert_same(played(key, 24, divided), whole)


def test_who_waits_plays_what_was_begun_at_once(key, whole):
    assert_same(played(key, 24, (128,), waiting), whole)


def test_how_many_environments_there_are_makes_no_difference(key, whole):
    _, few = played(key, 5, (128,))
    _, many = whole
    assert_same(few, jax.tree.map(lambda x: x[..., :5], many))


def scenarios_to_come(key, environments, episodes):
    """What each environment plays, episode after episode: (episode, env)."""
    keys = environment_keys(key, 0, environments)
    fold = jax.vmap(jax.random.fold_in, in_axes=(0, None))
    each = [draw_batch(Clock(), fold(fold(keys, SCENARIO_KEYS), n)) for n in range(episodes)]
    return {name: np.stack([np.asarray(scenario[name]) for scenario in each]) for name in each[0]}


def test_each_episode_is_the_one_drawn_for_its_environment_and_number(key, whole):
    stream, steps = whole
    coming = scenarios_to_come(key, 24, 64)
    word, state = np.asarray(steps.record["word"]), np.asarray(steps.record["state"])
    valid, ended = np.asarray(steps.valid), np.asarray(steps.outcome.ended)
    for env in range(24):
        begins = np.flatnonzero(state[:, env] == 0)
        assert begins[0] == 0
        assert len(begins) > 3
        for number, begin in enumerate(begins):
            assert begin % RESTART_EVERY == 0
            length = coming["length"][number, env]
            stop = begins[number + 1] if number + 1 < len(begins) else 128
            assert (word[begin:stop, env] == coming["word"][number, env]).all()
            # Valid while it is played, then idle; it ends once, in its last step.
            expected = np.arange(stop - begin) < length
            np.testing.assert_array_equal(valid[begin:stop, env], expected)
            now = np.flatnonzero(ended[begin:stop, env] & valid[begin:stop, env])
            assert now.tolist() == ([length - 1] if length <= stop - begin else [])
        assert stream.episode[env] == len(begins) - 1


def test_the_step_after_the_last_shows_the_final_state(whole):
    """So that the value of a state before a restart is always there to bootstrap from."""
    _, steps = whole
    state, valid, ended = (np.asarray(x) for x in (steps.record["state"], steps.valid, steps.outcome.ended))
    last, env = np.nonzero(valid[:-1] & ended[:-1])
    assert last.size > 100
    np.testing.assert_array_equal(state[last + 1, env], state[last, env] + 1)
    assert not valid[last + 1, env].any()


def test_memory_is_fresh_in_each_episode(whole):
    _, steps = whole
    np.testing.assert_array_equal(steps.record["memory"], steps.record["state"])


def test_every_step_of_every_environment_has_its_own_chance(whole):
    _, steps = whole
    drawn = np.asarray(steps.record["action"])
    assert len(np.unique(drawn)) > 0.99 * drawn.size
    np.testing.assert_array_equal(steps.outcome.rewards["driver"]["action"], drawn)


@pytest.mark.parametrize("seed", [0, 7, 2**31, 2**32 - 1, -1])
def test_a_seed_has_the_key_that_jax_gives_it(seed):
    plainly = jax.random.fold_in(jax.random.key(seed), EVALUATION)
    assert np.array_equal(*map(jax.random.key_data, (seed_key(seed, EVALUATION), plainly)))


def test_seeds_domains_and_indices_have_keys_of_their_own():
    data = [
        jax.random.key_data(environment_keys(seed_key(seed, domain), 0, 50))
        for seed in range(3)
        for domain in (TRAINING, EVALUATION)
    ]
    assert len(np.unique(np.concatenate(data), axis=0)) == 300


def follow(street):
    """Drives along its lane at full throttle, with pure pursuit of a point 4 m ahead."""

    def act(key, scenario, state, memory):
        car, maps = state.vehicle, street.world.maps
        point = jnp.minimum(jnp.round(car.along * 2).astype(jnp.int32) + 8, maps.route_x.shape[-1] - 1)
        dx = maps.route_x[scenario.map, scenario.route, point] - car.x
        dy = maps.route_y[scenario.map, scenario.route, point] - car.y
        left = dy * car.cos - dx * car.sin
        steering = jnp.arctan(2 * street.world.rules.wheelbase * left / (dx * dx + dy * dy + 1e-6))
        drive = jnp.stack([jnp.where(car.speed < 4, 1.0, 0.0), steering / street.world.rules.max_steering])
        record = {"x": car.x, "y": car.y, "along": car.along, "speed": car.speed, "route": scenario.route,
                  "step": state.step, "tau": scenario.traits[0]}  # fmt: skip
        return {"driver": drive, "pedestrian": jnp.ones((12, *car.x.shape), jnp.int32)}, memory, record

    return act


@pytest.fixture(scope="module")
def drive(street):
    """64 streets, 512 steps each, by a driver that keeps to its lane at 4 m/s."""
    play = jax.jit(lambda street, stream: rollout(street, follow(street), stream, 512))
    stream = jax.jit(lambda street: start(street, environment_keys(seed_key(1, TRAINING), 0, 64)))(street)
    return play(street, stream)


def test_along_is_the_distance_driven_on_the_route(drive):
    _, steps = drive
    seen = {name: np.asarray(x) for name, x in steps.record.items()}
    same = np.asarray(steps.valid)[1:] & np.asarray(steps.valid)[:-1] & (seen["step"][1:] > 0)
    driven = np.hypot(np.diff(seen["x"], axis=0), np.diff(seen["y"], axis=0))
    forward = np.diff(seen["along"], axis=0)
    assert np.abs(forward - driven)[same].max() < 0.12  # cutting a corner, or swinging out
    assert forward[same].min() > -1e-3
    assert forward[same].sum() == pytest.approx(driven[same].sum(), rel=0.01)


def test_streets_end_and_begin_again(street, drive):
    stream, steps = drive
    events, valid = steps.outcome.events, np.asarray(steps.valid)
    ended = np.asarray(steps.outcome.ended) & valid
    ends = [np.asarray(x) & valid for x in (events.goal, events.collision, events.timeout)]
    np.testing.assert_array_equal(sum(x.astype(int) for x in ends), ended)
    assert ends[0].sum() > 64  # it mostly arrives
    np.testing.assert_array_equal(valid[1:] | ended[:-1] | ~valid[:-1], True)
    begun = (np.asarray(steps.record["step"]) == 0).sum(axis=0) - 1
    np.testing.assert_array_equal(begun, stream.episode)
    # An arrival means that the route was driven.
    last, env = np.nonzero(ends[0])
    length = np.asarray(street.world.maps.route_length[0])[np.asarray(steps.record["route"])[last, env]]
    np.testing.assert_allclose(np.asarray(steps.record["along"])[last, env], length - 3, atol=1.0)

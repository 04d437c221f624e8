"""The street in the manner of JaxMARL: one compiled program for many environments, the same as single ones."""

import jax
import numpy as np
import pytest

from jaxwalk.adapters.jaxmarl import StreetMARL
from jaxwalk.adapters.players import AdapterError
from jaxwalk.sim.sim_config import SimConfig

HORIZON, COUNT, PEOPLE = 40, 6, 3
RULES = SimConfig(horizon=HORIZON, pedestrians=PEOPLE)
TRACES = []


@pytest.fixture(scope="module")
def env():
    return StreetMARL(config=RULES)


@pytest.fixture(scope="module")
def played(env):
    """Many environments side by side, and the first of them alone: 1.5 episodes of random actions."""

    def play(keys):
        TRACES.append(keys.shape)

        def act(key, count):
            names = enumerate(env.agents)
            return {
                name: jax.vmap(env.action_space(name).sample)(jax.random.split(jax.random.fold_in(key, i), count))
                for i, name in names
            }

        steps = jax.vmap(lambda state: state.step)

        def body(carry, key):
            many, one = carry
            actions = act(key, len(keys))
            step_keys = jax.random.split(key, len(keys))
            *_, _ = brought = jax.vmap(env.step)(step_keys, many, actions)
            alone = env.step(step_keys[0], one, {name: x[0] for name, x in actions.items()})
            return (brought[1], alone[1]), (
                brought[0],
                *brought[2:],
                alone[0],
                alone[2],
                steps(many),
                steps(brought[1]),
            )

        _, many = jax.vmap(env.reset)(keys)
        _, one = env.reset(keys[0])
        return jax.lax.scan(body, (many, one), jax.random.split(jax.random.key(1), 3 * HORIZON // 2))[1]

    compiled = jax.jit(play)
    compiled(jax.random.split(jax.random.key(3), COUNT))
    return jax.device_get(compiled(jax.random.split(jax.random.key(0), COUNT)))


def test_agents_and_spaces():
    env = StreetMARL()
    assert env.agents == ["driver", *(f"pedestrian_{i}" for i in range(12))] and env.num_agents == 13
    assert env.action_space("driver").shape == (2,) and env.action_space("pedestrian_4").n == 2
    assert sorted(env.agent_classes) == ["driver", "pedestrian"]
    people = StreetMARL(driver="route-follower")
    assert people.agents == env.agents[1:]
    assert len({id(people.observation_space(name)) for name in people.agents}) == 1
    assert StreetMARL(pedestrians="always-go").agents == ["driver"]
    with pytest.raises(AdapterError, match="leave one of them to the agents"):
        StreetMARL(driver="route-follower", pedestrians="always-go")


@pytest.mark.parametrize("policies", [{"driver": "route-follower"}, {"pedestrians": "always-go"}])
def test_agents_play_the_role_that_is_left_to_them(policies):
    env = StreetMARL(config=RULES, **policies)
    _, state = jax.jit(env.reset)(jax.random.key(0))
    actions = {name: np.zeros(env.action_space(name).shape, np.int32) for name in env.agents}
    step = jax.jit(env.step)
    for _ in range(10):
        seen, state, rewards, dones, infos = step(jax.random.key(1), state, actions)
    assert set(seen) == set(rewards) == set(env.agents) and set(dones) == {*env.agents, "__all__"}
    assert all(x.shape == (env.num_agents,) for x in infos.values())
    roles = {name.partition("/")[0] for name in infos if "/" in name}
    assert roles == set(env.agent_classes)
    assert (state.stream.state.vehicle.speed > 0.5) == ("driver" in policies)  # the agent's zeros leave it standing


def test_it_is_traced_once(played):
    assert TRACES == [(COUNT,)]


def test_many_are_as_one_alone(played):
    many, *_, alone, alone_rewards, _, _ = played
    for name, observation in alone.items():
        assert np.allclose(many[name][:, 0], observation, atol=1e-4), name
    assert np.allclose(played[1]["driver"][:, 0], alone_rewards["driver"], atol=1e-4)


def test_observations_lie_in_their_spaces(env, played):
    for name in env.agents:
        space, seen = env.observation_space(name), played[0][name]
        assert seen.shape == (3 * HORIZON // 2, COUNT, *space.shape)
        assert (seen >= space.low).all() and (seen <= space.high).all(), name


def test_episodes_end_for_all_and_begin_again(env, played):
    _, rewards, dones, infos, *_, before, after = played
    ended = dones["__all__"]
    assert ended.sum() >= COUNT  # each at the horizon at the latest
    assert all(np.array_equal(dones[name], ended) for name in env.agents)
    assert np.array_equal(after, np.where(ended, 0, before + 1))
    how = infos["goal"] + infos["collision"] + infos["timeout"].astype(int)
    assert how.shape == (*ended.shape, 1 + PEOPLE) and np.array_equal(how, np.repeat(ended[..., None], 1 + PEOPLE, 2))
    terms = sum(infos[name] for name in infos if "/" in name)
    assert np.allclose(np.stack([rewards[name] for name in env.agents], -1), terms, atol=1e-4)


def test_keys_of_either_kind_and_a_given_next_state(env):
    reset, step = jax.jit(env.reset), jax.jit(env.step)
    old, state = reset(jax.random.PRNGKey(5))
    new, _ = reset(jax.random.key(5))
    assert np.array_equal(old["driver"], new["driver"])
    available = {name: mask.tolist() for name, mask in env.get_avail_actions(state).items()}
    assert available == {name: [True, True] for name in env.agents[1:]}
    actions = {name: np.zeros(2, np.float32) if name == "driver" else np.int32(1) for name in env.agents}
    for _ in range(HORIZON):
        _, state, _, dones, _ = step(jax.random.key(0), state, actions, state)
    assert bool(dones["__all__"]) and int(state.step) == HORIZON - 1  # it came back to the state before its last step

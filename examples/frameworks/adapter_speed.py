"""How fast the Gymnasium adapter is beside the native loop, and whether a long loop holds its memory.

    python examples/frameworks/adapter_speed.py                   # both at 512 environments, in turns
    python examples/frameworks/adapter_speed.py --steps 1000000   # then so many steps of a single environment

Needs ``pip install 'jaxwalk[envs]'``. Native is `jaxwalk.rollout.rollout`: same observation, same pay, random actions.
"""

import argparse
import time

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np

import jaxwalk.adapters.gymnasium
from jaxwalk import ByRole, Street
from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start
from jaxwalk.sim.weights import DRIVER_WEIGHTS

gymnasium.register_envs(jaxwalk.adapters.gymnasium)

BLOCK = 256  # native steps in one call


def native(street, environments):
    """A function that plays BLOCK steps of every environment and returns how long they took."""

    def act(key, scenario, state, memory):
        words = jnp.moveaxis(jax.random.key_data(key), -1, 0)  # keys are random: as good as fresh numbers
        action = jnp.stack([words[0] >> 16, words[0] & 0xFFFF]).astype(jnp.float32) * 2.0**-15 - 1
        seen = street.observe(scenario, state, "driver", "route")
        return ByRole(action, jnp.ones((12, environments), jnp.int32)), memory, seen

    def kept(step):
        return step.record, sum(step.outcome.rewards.driver.values()), step.outcome.ended, step.valid

    play = jax.jit(lambda stream: rollout(street, act, stream, BLOCK, keep=kept), donate_argnums=0)
    stream = start(street, environment_keys(seed_key(0, TRAINING), 0, environments))

    def run():
        nonlocal stream
        begun = time.perf_counter()
        stream, _ = jax.block_until_ready(play(stream))
        return time.perf_counter() - begun

    return run


def adapted(environments, mode):
    """The same with the vector environment."""
    env = gymnasium.make_vec("jaxwalk/Street-v0", num_envs=environments, autoreset_mode=mode)
    env.reset(seed=0)
    random = np.random.default_rng(0)
    actions = random.uniform(-1, 1, (16, environments, 2)).astype(np.float32)

    def run():
        begun = time.perf_counter()
        for number in range(BLOCK):
            env.step(actions[number % 16])
        return time.perf_counter() - begun

    return run


def speed(environments, rounds):
    street = Street.create(driver_weights=DRIVER_WEIGHTS["fast"])
    loops = {
        "native": native(street, environments),
        "vector, next step": adapted(environments, "NextStep"),
        "vector, same step": adapted(environments, "SameStep"),
    }
    taken = {name: [] for name in loops}
    for number in range(rounds + 2):  # in turns, so that whatever else the machine does hits all of them
        for name, loop in loops.items():
            seconds = loop()
            if number >= 2:  # compiled, and away from the first steps
                taken[name].append(seconds)
    fastest = min(taken["native"])
    for name, seconds in taken.items():
        rate = environments * BLOCK / np.array([min(seconds), np.median(seconds)])
        share = fastest / min(seconds)
        print(f"{name:18} {rate[0]:>10,.0f} steps/s (median {rate[1]:,.0f}), {share:.2f} of native")


def resident():
    """Memory of this process now [MB]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def long_loop(steps):
    env = gymnasium.make("jaxwalk/Street-v0")
    env.reset(seed=0)
    env.action_space.seed(0)
    begun, episodes = time.perf_counter(), 0
    for number in range(steps):
        *_, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            episodes += 1
            env.reset()
        if number + 1 in (steps // 100, steps // 2, steps):
            live = len(jax.live_arrays())
            rate = (number + 1) / (time.perf_counter() - begun)
            now = f"step {number + 1:>9,}: {resident():,.0f} MB, {live} live arrays, {episodes} episodes"
            print(f"{now}, {rate:,.0f} steps/s", flush=True)


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--environments", type=int, default=512)
parser.add_argument("--rounds", type=int, default=10, help="of 256 steps each")
parser.add_argument("--steps", type=int, default=0, help="of the long loop; 0: none")
parser.add_argument("--brief", action="store_true", help="only to see that it runs")
options = parser.parse_args()
if options.brief:
    options.rounds, options.steps = 1, 1000
speed(options.environments, options.rounds)
if options.steps:
    long_loop(options.steps)

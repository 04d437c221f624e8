"""Measure the speed of the Gymnasium adapter beside the native loop, and the memory of a long loop.

    python examples/frameworks/adapter_speed.py                   # both at 512 environments, in turns
    python examples/frameworks/adapter_speed.py --steps 1000000   # also a long loop of a single environment

Needs ``pip install 'jaxwalk[envs]'``.
The native loop is `jaxwalk.rollout.rollout`: same observation, same rewards, random actions.
"""

import argparse
import time

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np

import jaxwalk.adapters.gymnasium
from jaxwalk import Street
from jaxwalk.recipes import RECIPES
from jaxwalk.rollout import RESTART_EVERY, TRAINING, advance, environment_keys, restart, rollout, seed_key, start

gymnasium.register_envs(jaxwalk.adapters.gymnasium)

BLOCK = 256  # native steps in one call


def native(street, environments):
    """Return two functions that play BLOCK steps of every environment and return the time [s]: one compiled loop, and a
    Python loop over a compiled step, which is the best that a policy in Python can have."""

    def act(key, scenario, state, memory):
        words = jnp.moveaxis(jax.random.key_data(key), -1, 0)  # keys are random numbers already
        action = jnp.stack([words[0] >> 16, words[0] & 0xFFFF]).astype(jnp.float32) * 2.0**-15 - 1
        seen = street.observe(scenario, state, street.view("driver", "route"))
        return {"driver": action, "pedestrian": jnp.ones((12, environments), jnp.int32)}, memory, seen

    def kept(step):
        return step.record, sum(step.outcome.rewards["driver"].values()), step.outcome.ended, step.valid

    play = jax.jit(lambda stream: rollout(street, act, stream, BLOCK, keep=kept), donate_argnums=0)
    stream = start(street, environment_keys(seed_key(0, TRAINING), 0, environments))

    def one_step(stream):
        stream, step = advance(street, act, stream, stream.key)
        return stream, jnp.concatenate([step.record, kept(step)[1][None]])

    step = jax.jit(one_step, donate_argnums=0)
    again = jax.jit(lambda stream: restart(street, stream), donate_argnums=0)

    def compiled():
        nonlocal stream
        begun = time.perf_counter()
        stream, _ = jax.block_until_ready(play(stream))
        return time.perf_counter() - begun

    def in_python():
        nonlocal stream
        begun = time.perf_counter()
        for number in range(BLOCK):
            stream, seen = step(again(stream) if number % RESTART_EVERY == 0 else stream)
            np.array(seen)
        return time.perf_counter() - begun

    return compiled, in_python


def adapted(environments, mode):
    """Return such a function for the vector environment."""
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
    street = Street.create(driver_weights=RECIPES["fast"].driver_weights)
    compiled, in_python = native(street, environments)
    loops = {
        "native, compiled loop": compiled,
        "native, Python loop": in_python,
        "vector, next step": adapted(environments, "NextStep"),
        "vector, same step": adapted(environments, "SameStep"),
    }
    taken = {name: [] for name in loops}
    for number in range(rounds + 2):  # in turns, so that other load on the machine affects all of them
        for name, loop in loops.items():
            seconds = loop()
            if number >= 2:  # after compiling and the first steps
                taken[name].append(seconds)
    fastest = [min(seconds) for name, seconds in taken.items() if name.startswith("native")]
    for name, seconds in taken.items():
        rate = environments * BLOCK / np.array([min(seconds), np.median(seconds)])
        of_compiled, of_python = (native / min(seconds) for native in fastest)
        shares = f"{of_compiled:.2f} and {of_python:.2f} of the native loops"
        print(f"{name:22} {rate[0]:>10,.0f} steps/s (median {rate[1]:,.0f}), {shares}")


def resident():
    """Return the current memory of this process [MB]."""
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
parser.add_argument("--rounds", type=int, default=10, help="number of rounds of 256 steps")
parser.add_argument("--steps", type=int, default=0, help="steps of the long loop; 0 leaves it out")
parser.add_argument("--brief", action="store_true", help="run very briefly, as a test")
options = parser.parse_args()
if options.brief:
    options.rounds, options.steps = 1, 1000
speed(options.environments, options.rounds)
if options.steps:
    long_loop(options.steps)

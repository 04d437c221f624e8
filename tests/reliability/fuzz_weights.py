"""A thousand policies with absurd numbers: each gets a proper answer, or is refused in words.

    .venv/bin/python tests/reliability/fuzz_weights.py                 1,000 cases
    .venv/bin/python tests/reliability/fuzz_weights.py --case 17       one of them again, and what it says

The shipped policies' weights are scaled by 1e-30 to 1e30, some of them are set to the edges of float32, to NaN and to
infinity, and bits are flipped. A proper answer has rates that add up, only finite numbers, and no warning beside it.
Numbers that aren't finite in the file must be refused while it is loaded; those that overflow while it plays, by then.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from hostile.judging import LONGEST, refused
from jaxwalk import Street
from jaxwalk.evaluation import evaluate_grid, with_mode
from jaxwalk.policies import load_policy, save_policy, shipped_policy
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.sim_config import SimConfig

EPISODES = 16
"""Of each case, played at once."""
HORIZON = 200
"""Steps of an episode: enough for goals, collisions and timeouts."""
FAST, PAPER = ("co-trained", "single-agent"), ("paper-co-trained", "paper-single-agent")
"""Drivers with networks of one shape; the paper's sample their actions, so that their spread counts too."""
PEOPLE = {FAST: "learned", PAPER: "paper-learned"}
LIMITS = np.finfo(np.float32)
EDGES = np.array(
    [LIMITS.max, LIMITS.min, LIMITS.tiny, -LIMITS.tiny, LIMITS.smallest_subnormal, 1e38, -1e38, 1e19, 0.0, -0.0],
    np.float32,
)
UNREADABLE = np.array([np.nan, np.inf, -np.inf], np.float32)
"""What no file may hold."""


def _scaled(random, x):
    with np.errstate(over="ignore", under="ignore"):
        return x * np.float32(10.0 ** random.uniform(-30, 30))


def _some(values):
    def put(random, x):
        changed = x.copy()
        places = random.integers(0, x.size, random.integers(1, 6))
        changed.reshape(-1)[places] = random.choice(values, len(places))
        return changed

    return put


def _flipped(random, x):
    bits = x.copy().view(np.uint32).reshape(-1)
    bits[random.integers(0, x.size, 3)] ^= np.uint32(1) << random.integers(0, 32, 3).astype(np.uint32)
    return bits.view(np.float32).reshape(x.shape)


def _filled(random, x):
    return np.full_like(x, random.choice(EDGES))


CHANGES = {
    "scaled": _scaled,
    "edges": _some(EDGES),
    "unreadable": _some(UNREADABLE),
    "flipped": _flipped,
    "filled": _filled,
}
OFTEN = (0.45, 0.25, 0.05, 0.15, 0.1)
"""How often each change is made."""


def make(number, drivers, folder):
    """Write the case's policy files; return the driver's name, what was changed, and the file of each role."""
    random = np.random.default_rng(number)
    chosen = {"driver": str(random.choice(drivers)), "pedestrian": PEOPLE[drivers]}
    spoiled = random.choice(["driver", "pedestrian", "both"], p=(0.5, 0.3, 0.2))
    change = str(random.choice(list(CHANGES), p=OFTEN))
    everywhere = random.random() < 0.5
    files = {}
    for role, name in chosen.items():
        policy = load_policy(shipped_policy(role, name), role)
        actor = policy.actor
        if spoiled in (role, "both"):
            actor = _spoiled(random, actor, CHANGES[change], everywhere)
        files[role] = folder / f"{role}.safetensors"
        save_policy(files[role], {role: actor}, {})
    return chosen["driver"], f"{change} ({spoiled}{', everywhere' if everywhere else ''})", files


def _spoiled(random, actor, change, everywhere):
    """Return the actor with a change in one of its arrays, or in all."""
    import equinox as eqx
    import jax

    leaves, structure = jax.tree.flatten(eqx.filter(actor, eqx.is_array))
    chosen = range(len(leaves)) if everywhere else [random.integers(len(leaves))]
    state = random.bit_generator.state
    for i in chosen:
        random.bit_generator.state = state  # so that all arrays are scaled by the same number
        leaves[i] = change(random, np.asarray(leaves[i]))
    return eqx.combine(jax.tree.unflatten(structure, leaves), actor)


def answer(street, drivers, files):
    """Evaluate the case. Raise AssertionError if its answer is no proper one."""
    sample = drivers is PAPER
    driver = with_mode(load_policy(files["driver"], "driver"), sample=sample)
    people = with_mode(load_policy(files["pedestrian"], "pedestrian"), sample=True)
    source = Drawn(street, 3, EPISODES)
    results, _ = evaluate_grid(street, {"driver": driver}, {"people": people}, source, batch=EPISODES)
    results.to_json()  # which refuses what isn't finite
    (cell,) = results.cells
    total = cell.goal_rate.value + cell.collision_rate.value + cell.timeout_rate.value
    assert abs(total - 1) < 1e-9, total


def check(number, drivers, street, folder):
    """Play a case: return what was changed, and the message if it was refused."""
    _, changed, files = make(number, drivers, folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        message = refused(lambda: answer(street, drivers, files))
    unreadable = changed.startswith("unreadable")
    assert not unreadable or "finite float32" in (message or ""), message
    assert len(message or "") < LONGEST
    return changed, message


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--cases", type=int, default=1000)
    asked.add_argument("--case", type=int, help="only this one, and show what it says")
    options = asked.parse_args()
    street, ends, failed, begun = Street.create(config=SimConfig(horizon=HORIZON)), Counter(), [], time.monotonic()
    numbers = range(options.cases) if options.case is None else [options.case]
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            drivers = (FAST, PAPER)[number % 2]
            try:
                changed, message = check(number, drivers, street, Path(folder))
            except Exception as error:
                failed.append(number)
                print(f"case {number} FAILED: {type(error).__name__}: {error}", flush=True)
                continue
            ends[changed.partition(" ")[0], end(message)] += 1
            if options.case is not None:
                print(changed, message or "has a proper answer", sep=": ")
    for (change, how), count in sorted(ends.items()):
        print(f"{change}: {count} {how}")
    print(f"{len(numbers)} cases, {len(failed)} failed, in {time.monotonic() - begun:.0f} s")
    return bool(failed)


def end(message):
    """How a case ended, in a few words."""
    if message is None:
        return "answered"
    return "refused while loading" if "finite float32" in message else "refused while playing"


if __name__ == "__main__":
    sys.exit(main())

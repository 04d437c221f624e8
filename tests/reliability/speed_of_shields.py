"""Print how many steps a second an evaluation makes with a driver, bare and behind each shield.

    python tests/reliability/speed_of_shields.py               # co-trained in the suite paper: some two minutes
    python tests/reliability/speed_of_shields.py town --suite town --turns 5

Each plays the same scenarios among `always-go`, in turns: a machine's speed changes, so each turn has its own shares.
All is compiled before. Steps are those until each episode's end. Nothing else should run meanwhile.
"""

from __future__ import annotations

import argparse
import time
from statistics import median

import jax

from jaxwalk.evaluation import evaluate
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.policies.shield_names import SHIELD_NAMES
from jaxwalk.provenance import cores
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.suites import SUITES


def main() -> None:
    """Print a line for the bare driver, and one for each shield."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("driver", nargs="?", default="co-trained")
    parser.add_argument("--suite", choices=SUITES, default="paper")
    parser.add_argument("--episodes", type=int, default=2048)
    parser.add_argument("--seed", type=int, default=74)
    parser.add_argument("--turns", type=int, default=3)
    given = parser.parse_args()
    jax.config.update("jax_num_cpu_devices", cores())
    street = world_of([given.driver], SUITES[given.suite])
    people, source = contestant(street, "pedestrian", "always-go"), Drawn(street, given.seed, given.episodes)
    names = (given.driver, *(f"{given.driver}+{shield}" for shield in SHIELD_NAMES))
    played = {name: {"driver": contestant(street, "driver", name), "pedestrian": people} for name in names}
    for policies in played.values():
        evaluate(street, policies, Drawn(street, given.seed, 1))
    turns = [{name: _speed(street, policies, source) for name, policies in played.items()} for _ in range(given.turns)]
    for name in names:
        shares = [turn[name] / turn[given.driver] for turn in turns]
        speed = median(turn[name] for turn in turns)
        print(
            f"{name}: {speed:,.0f} steps/s, {median(shares):.0%} ({min(shares):.0%} to {max(shares):.0%}) of the bare's"
        )


def _speed(street: Street, policies: Roles[Policy], source: Drawn) -> float:
    """Return how many steps are made per second."""
    begun = time.perf_counter()
    rows = evaluate(street, policies, source)
    return int(rows[OUTCOMES].steps.sum()) / (time.perf_counter() - begun)


if __name__ == "__main__":
    main()

"""Print how many steps a second an evaluation makes with a driver, bare and behind each shield.

    python tests/reliability/speed_of_shields.py               # co-trained in the suite paper: some two minutes
    python tests/reliability/speed_of_shields.py town --suite town

Each plays the same scenarios among `always-go` twice, and the second time counts: all is compiled then. Steps are those
until each episode's end. Nothing else should run meanwhile.
"""

from __future__ import annotations

import argparse
import time

import jax

from jaxwalk.evaluation import evaluate
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.policies.shield_names import SHIELD_NAMES
from jaxwalk.provenance import cores
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.suites import SUITES


def main() -> None:
    """Print a line for the bare driver, and one for each shield."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("driver", nargs="?", default="co-trained")
    parser.add_argument("--suite", choices=SUITES, default="paper")
    parser.add_argument("--episodes", type=int, default=2048)
    parser.add_argument("--seed", type=int, default=74)
    given = parser.parse_args()
    jax.config.update("jax_num_cpu_devices", cores())
    street = world_of([given.driver], SUITES[given.suite])
    people, source = contestant(street, "pedestrian", "always-go"), Drawn(street, given.seed, given.episodes)
    bare = None
    for name in (given.driver, *(f"{given.driver}+{shield}" for shield in SHIELD_NAMES)):
        policies = {"driver": contestant(street, "driver", name), "pedestrian": people}
        evaluate(street, policies, source)
        begun = time.perf_counter()
        rows = evaluate(street, policies, source)
        speed = int(rows[OUTCOMES].steps.sum()) / (time.perf_counter() - begun)
        bare = bare or speed
        print(f"{name}: {speed:,.0f} steps/s, {speed / bare:.0%} of the bare driver's", flush=True)


if __name__ == "__main__":
    main()

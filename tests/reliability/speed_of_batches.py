"""Print how many steps a second an evaluation makes in batches of several sizes; `*` marks the usual one.

    python tests/reliability/speed_of_batches.py crowd arterial blind-corner town paper   # some ten minutes

Each plays the same scenarios with `co-trained` among `always-go`, in turns: a machine's speed changes. All is compiled
before. Steps are those until each episode's end. Nothing else should run meanwhile.
"""

from __future__ import annotations

import argparse
import time

import jax

from jaxwalk.evaluation import episodes_at_once, evaluate
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.provenance import cores
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.suites import SUITES

DRIVER = "co-trained"


def main() -> None:
    """Print a line for each suite and size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suites", nargs="+", choices=SUITES)
    parser.add_argument("--sizes", type=int, nargs="+", default=(512, 256, 128, 64))
    parser.add_argument("--episodes", type=int, default=2048)
    parser.add_argument("--seed", type=int, default=74)
    parser.add_argument("--turns", type=int, default=2)
    given = parser.parse_args()
    jax.config.update("jax_num_cpu_devices", cores())
    for suite in given.suites:
        _compare(suite, given.sizes, given.turns, (given.seed, given.episodes))


def _compare(suite: str, sizes: list[int], turns: int, drawn: tuple[int, int]) -> None:
    """Print the suite's lines."""
    street = world_of([DRIVER], SUITES[suite])
    policies = {
        "driver": contestant(street, "driver", DRIVER),
        "pedestrian": contestant(street, "pedestrian", "always-go"),
    }
    usual, speeds = episodes_at_once(street, policies), {size: [] for size in sizes}
    for size in sizes:
        evaluate(street, policies, Drawn(street, drawn[0], 1), batch=size)
    for size in list(sizes) * turns:
        begun = time.perf_counter()
        rows = evaluate(street, policies, Drawn(street, *drawn), batch=size)
        speeds[size].append(int(rows[OUTCOMES].steps.sum()) / (time.perf_counter() - begun))
    for size, each in speeds.items():
        people, mark = int(street.world.rules.pedestrians), "*" if size == usual else ""
        print(f"{suite}, {people} people, {size} at once{mark}: {', '.join(f'{x:,.0f}' for x in each)} steps/s")


if __name__ == "__main__":
    main()

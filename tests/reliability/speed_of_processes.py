"""Compare the speed of a training by two processes with that of the same training by one process with two shards.

    python tests/reliability/speed_of_processes.py                 # the recipes fast and paper: some minutes
    python tests/reliability/speed_of_processes.py fast --turns 5

Both play the same environments and make the same updates of a recipe, at its own size, one device a shard. They take
turns of at least a second (at least one update), so that a noisy machine treats them alike. A ratio is the speed of two
processes / that of two shards in one turn; the bound is that of `speed_against.py`. Nothing else should run meanwhile.
"""

from __future__ import annotations

import argparse
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from jaxwalk.cli.group import Group, join, take_cores
from jaxwalk.runs.watchdog import LAUNCHED
from reliability.speed_against import Turn, lower_bound, take_turns

SHARDS = 2
WARM = 3
"""Updates before the first turn."""
MADE = "made"
"""Begins the lines of a process; libraries print others."""
SECONDS = 1.0
"""Shortest turn."""


def work(recipe: str, process: int, processes: int, port: int) -> None:
    """Be one of the processes: for each number on standard input, make as many updates and print their seconds."""
    import jax

    jax.config.update("jax_num_cpu_devices", SHARDS // processes)
    if processes > 1:
        os.environ[LAUNCHED] = ""  # as `jaxwalk train --processes` starts them
        group = Group(f"127.0.0.1:{port}", process, processes, SHARDS // processes)
        join(group)
        jax.devices()
        take_cores(group)
    from jaxwalk.learning import mappo
    from jaxwalk.recipes import RECIPES
    from jaxwalk.rollout import TRAINING, seed_key
    from jaxwalk.runs.street import fixed_policies, make_street, shared_out
    from jaxwalk.shards import everywhere, mesh_of

    experiment = shared_out(RECIPES[recipe])
    street, config = make_street(experiment), replace(experiment.train, updates=1)  # as `jaxwalk train` compiles it
    assert config.shards == SHARDS, config.shards
    learner = mappo.init(street, config, seed_key(0, TRAINING), others=fixed_policies(experiment))
    street = everywhere(street, mesh_of(config.shards))
    for line in chain(("1",), iter(sys.stdin.readline, "")):
        begun = time.perf_counter()
        for _ in range(int(line)):
            learner, _metrics = jax.block_until_ready(mappo.update(street, config, learner))
        print(MADE, time.perf_counter() - begun, experiment.steps_per_update, flush=True)


@contextmanager
def training(recipe: str, processes: int) -> Iterator[Turn]:
    """Start the processes, which compile and warm up, and give their turns: steps per second."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, __file__, recipe, "--worker"]
    started = [
        subprocess.Popen([*command, str(process), str(processes), str(port)], stdin=subprocess.PIPE,
                         stdout=subprocess.PIPE, text=True, env=os.environ)
        for process in range(processes)
    ]  # fmt: skip

    def said() -> tuple[float, int]:
        """Return the seconds of the slowest process, and the steps of an update."""
        found = [
            next((line.split() for line in process.stdout or () if line.startswith(MADE)), None) for process in started
        ]
        lines = [words for words in found if words]
        if len(lines) < len(started):
            raise SystemExit(f"a process of {recipe} ended; see above")
        return max(float(seconds) for _, seconds, _ in lines), int(lines[0][2])

    def made(updates: int) -> float:
        """Let all make so many updates, and return the steps per second."""
        for process in started:
            assert process.stdin
            process.stdin.write(f"{updates}\n")
            process.stdin.flush()
        seconds, steps = said()
        return updates * steps / seconds

    try:
        _, steps = said()  # compiled
        least = 1 + int(SECONDS * made(WARM) / steps)
        yield lambda: made(least)
    finally:
        for process in started:
            process.kill()
        for process in started:
            process.wait()


def main() -> None:
    """Compare, and print a line for each recipe."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recipes", nargs="*", default=["fast", "paper"])
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--worker", nargs=3, type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        return work(given.recipes[0], *given.worker)
    for recipe in given.recipes:
        with training(recipe, 1) as shards, training(recipe, SHARDS) as processes:
            speeds = take_turns(shards, processes, given.turns)
        ratios = [after / before for before, after in speeds]
        before, after = (statistics.median(x) for x in zip(*speeds, strict=True))
        speed = f"2 shards {before:,.0f}, 2 processes {after:,.0f} steps/s"
        spread = f"bound {lower_bound(ratios)}, {min(ratios):.3f} to {max(ratios):.3f} in {len(ratios)} turns"
        print(f"{recipe}: {speed}; ratio {statistics.median(ratios):.3f}, {spread}", flush=True)
    return None


if __name__ == "__main__":
    main()

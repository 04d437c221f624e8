"""Evaluate many scenarios three times, the third and second among deaths, and see that the same comes out.

    python tests/reliability/million_scenarios.py --episodes 1000000 --out runs/million

1. in one process: ``jaxwalk evaluate``;
2. on a Ray of this machine: ``--cluster local``, of which two workers are killed (SIGKILL) while they play;
3. as 16 parts by hand: two of them are killed and evaluated again, one is evaluated twice; then ``jaxwalk merge``.

results.json (all counts, sums, quantiles, histograms and intervals) and episodes.csv (a row per scenario) must be the
same bytes each time. It prints the processor seconds of each step, and the most memory of its largest processes. Exit
code 1 if anything differs, or if a process of 2 or 3 took more than --most GB. --steps goes on after those that are
done. Needs Linux, and pip install "jaxwalk[cluster]".
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from reliability.process_tree import Tree, watched

JAXWALK = [sys.executable, "-m", "jaxwalk"]
FILES = ("results.json", "episodes.csv")
STEPS = ("one", "ray", "parts")
"""Steps that can be left out if they are done; the merge of parts and the comparison are always made."""


def say(what: str, trees: list[Tree]) -> float:
    """Print what a step took; return the most memory of a process [GB]."""
    seconds = sum(sum(tree.seconds.values()) for tree in trees)
    peaks = sorted((peak / 1024 for tree in trees for peak in tree.peaks.values()), reverse=True)
    print(f"{what}: {seconds:.0f} processor seconds; GB at most, of the largest processes: "
          f"{', '.join(f'{peak:.2f}' for peak in peaks[:5])}", flush=True)  # fmt: skip
    return peaks[0]


def run(command: list[str]) -> Tree:
    """Run a command that has to succeed."""
    tree, code = watched(command)
    if code:
        sys.exit(f"exit code {code}: {' '.join(command)}")
    return tree


def on_ray(command: list[str], out: Path) -> Tree:
    """Run a command on a cluster, and kill one of its workers when a part is finished, and another one later."""
    killed: list[int] = []

    def kill(tree: Tree, there: list[int]) -> None:
        finished = len(list(out.glob("parts/*/part.json")))
        playing = [pid for pid in there if tree.names[pid].startswith("ray::_played") and pid not in killed]
        if len(killed) < 2 and finished > 2 * len(killed) and playing:
            killed.append(playing[-1])
            os.kill(playing[-1], signal.SIGKILL)

    tree, code = watched([*command, "--cluster", "local", "--out", str(out)], kill)
    if code or len(killed) < 2:
        sys.exit(f"exit code {code}, {len(killed)} workers killed")
    print(f"killed {len(killed)} workers")
    return tree


def by_hand(command: list[str], out: Path, parts: int) -> list[Tree]:
    """Evaluate parts one after the other; the first and the last are killed and evaluated again, the last one twice."""
    trees = []
    for number in range(1, parts + 1):
        part = [*command, "--part", f"{number}/{parts}", "--out", str(out / str(number))]
        if number in (1, parts):
            _kill_while_it_plays(part, out / str(number))
        trees.append(run(part))
    trees.append(run([*command, "--part", f"{parts}/{parts}", "--out", str(out / "again")]))
    return trees


def _kill_while_it_plays(part: list[str], folder: Path) -> None:
    """Begin a part, and kill it a second after it has locked its folder."""
    with subprocess.Popen(part, stdout=subprocess.DEVNULL) as process:
        while not (folder / ".lock").exists() and process.poll() is None:
            time.sleep(0.05)
        time.sleep(1)
        if process.poll() is not None:
            sys.exit(f"{folder} ended before it could be killed; take more --episodes")
        process.kill()
    print(f"killed {folder}")


def main() -> int:
    """Play, compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--episodes", type=int, default=8192)
    parser.add_argument("--by-hand", type=int, default=16, help="number of parts by hand")
    parser.add_argument("--driver", default="route-follower")
    parser.add_argument("--most", type=float, default=1.5, help="most memory of a process that isn't the first [GB]")
    parser.add_argument("--out", type=Path, default=Path("runs/million"))
    parser.add_argument("--steps", nargs="+", choices=STEPS, default=STEPS)
    given = parser.parse_args()
    one, ray, parts, merged = (given.out / name for name in ("one", "ray", "parts", "merged"))
    command = [*JAXWALK, "evaluate", "--driver", given.driver, "--episodes", str(given.episodes)]
    most = 0.0
    if "one" in given.steps:
        say("one process", [run([*command, "--out", str(one)])])
    if "ray" in given.steps:
        most = say("on Ray", [on_ray(command, ray)])
    if "parts" in given.steps:
        most = max(most, say("parts by hand, and one again", by_hand(command, parts, given.by_hand)))
    folders = [str(path) for path in parts.iterdir()]
    most = max(most, say("their merge", [run([*JAXWALK, "merge", *folders, "--out", str(merged)])]))
    different = [f"{folder}/{name}" for folder in (ray, merged) for name in FILES
                 if (folder / name).read_bytes() != (one / name).read_bytes()]  # fmt: skip
    print(f"differ: {', '.join(different)}" if different else "the same bytes three times")
    return int(bool(different) or most > given.most)


if __name__ == "__main__":
    sys.exit(main())

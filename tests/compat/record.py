"""Record how jaxwalk behaves, so that a later version can be compared with it.

    .venv/bin/python tests/compat/record.py tests/compat/recorded            # record everything: half an hour
    .venv/bin/python tests/compat/record.py tests/compat/recorded updates    # record some parts again

The folder `recorded` holds what version 0.1 did at commit ee64c7f. This script uses only the command line of the
jaxwalk that its Python imports, so that it runs in a checkout of any version. Use `compare.py` to compare.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PEOPLE = ("always-go", "learned")
RULES = ("random", "constant-speed", "rule-based", "rule-based-braking", "route-follower")
EVALUATIONS = {
    "all": {"driver": (*RULES, "single-agent", "co-trained"), "pedestrians": PEOPLE, "episodes": (2000,)},
    "oracle": {"driver": ("oracle",), "pedestrians": PEOPLE, "episodes": (512,)},
    "paper": {"driver": ("paper-co-trained",), "pedestrians": ("paper-learned",), "episodes": (512,)},
    "multipliers": {
        "driver": ("route-follower",), "pedestrians": ("learned",), "jaywalk-multiplier": (0.0, 0.5, 1.0),
        "episodes": (512,),
    },
    "sampled": {
        "driver": ("co-trained",), "pedestrians": ("learned",), "episodes": (512,), "seed": (7,),
        "driver-acts": ("sample",), "pedestrians-act": ("mode",),
    },
    "quick": {"driver": ("co-trained",), "pedestrians": PEOPLE, "episodes": (128,)},
}  # fmt: skip
"""Options of ``jaxwalk evaluate``. To record 0.1, write the two of ``sampled`` as it had them (docs/migrating.md)."""
SCENARIOS = ((0, 1, 0.25), (1, 700, 0.25), (1, 701, 1.0), (12345, 100, 0.25), (2**31 - 1, 33, 0.0))
"""Sets of scenarios whose hash is recorded: seed, number of scenarios and jaywalk multiplier."""
ALONE = ("--single-agent",)
TRAININGS = {
    f"{recipe} {'single-agent' if alone else 'co-trained'} on {shards}": (
        "--recipe", recipe, *(ALONE if alone else ()), "--shards", str(shards), "--updates", "3",
        "--environments", "48", "--steps", "128", "--minibatches", "4",
    )
    for recipe in ("fast", "paper") for alone in (False, True) for shards in (1, 2)
}  # fmt: skip
"""Options of ``jaxwalk train``, by name."""
QUICK_TO_COMPILE = "--xla_backend_optimization_level=0"
"""Three small updates are mostly compiling."""
TINY = {"actor_hidden": [16], "critic_hidden": [16]}
"""Networks of the recorded run folder, whose files are small therefore."""
PARTS = ("scenarios", "evaluations", "updates", "trained")


class CommandError(Exception):
    """A command failed; the message holds what it printed."""


def jaxwalk(*arguments: str | Path, folder: Path, flags: str = "") -> str:
    """Run a command in a folder and return its standard output. Raise CommandError if it fails.

    The compiler's flags change rounding, and so outcomes: those of the caller are dropped.
    """
    dropped = ("PYTHONWARNINGS", "JAX_DISABLE_MOST_OPTIMIZATIONS")  # compiled otherwise, it rounds otherwise
    keep = {name: value for name, value in os.environ.items() if name not in dropped}
    environment = {**keep, "JAX_NUM_CPU_DEVICES": "2", "XLA_FLAGS": flags}
    command = [sys.executable, "-m", "jaxwalk", *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CommandError(f"jaxwalk {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return done.stdout


def scenario_hash(seed: int, episodes: int, multiplier: float, *, folder: Path) -> str:
    """Return the hash of a set of scenarios."""
    options = ("--episodes", str(episodes), "--seed", str(seed), "--jaywalk-multiplier", str(multiplier))
    document = json.loads(jaxwalk("evaluate", "--driver", "constant-speed", *options, "--json", folder=folder))
    return document["scenarios"]["hash"]


def evaluation(options: dict[str, tuple], *, folder: Path) -> dict:
    """Evaluate and return the JSON document, and the outcomes of each cell as letters: goal, collision, timeout."""
    out = Path(tempfile.mkdtemp(dir=folder))
    arguments = [str(x) for name, values in options.items() for x in (f"--{name}", *values)]
    jaxwalk("evaluate", *arguments, "--out", out, folder=folder)
    outcomes: dict[str, str] = {}
    for path in sorted(out.glob("episodes*.csv")):
        with path.open(newline="") as file:
            for row in csv.DictReader(file):
                cell = f"{row['driver']} among {row['pedestrians']}{path.stem.removeprefix('episodes')}"
                outcomes[cell] = outcomes.get(cell, "") + row["outcome"][0]
    return {"outcomes": outcomes, "document": json.loads((out / "results.json").read_text())}


def updates(options: tuple[str, ...], *, folder: Path) -> list[dict]:
    """Train and return the lines of metrics.jsonl."""
    run = Path(tempfile.mkdtemp(dir=folder)) / "run"
    jaxwalk("train", "--run", run, *options, folder=folder, flags=QUICK_TO_COMPILE)
    return metrics(run)


def metrics(run: Path) -> list[dict]:
    """Return the lines of metrics.jsonl without the time that each took."""
    lines = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    return [{name: x for name, x in line.items() if name != "seconds"} for line in lines]


def make_trained(run: Path, *, folder: Path) -> None:
    """Make a run folder of 3 planned updates of which 2 are made: config, metrics, checkpoint and policy."""
    sizes = ("--environments", "12", "--steps", "32", "--minibatches", "2", "--shards", "1")
    jaxwalk("train", "--run", run, *sizes, "--updates", "1", folder=folder)
    config = json.loads((run / "config.json").read_text())
    for role in ("driver", "pedestrian"):
        config["train"][role].update(TINY)
    shutil.rmtree(run)
    run.mkdir()
    for planned in (2, 3):
        config["train"]["updates"] = planned
        (run / "config.json").write_text(json.dumps(config, indent=2) + "\n")
        if planned == 2:
            jaxwalk("train", "--resume", run, folder=folder)
    for path in (*run.glob("events.out.*"), run / ".lock"):
        path.unlink(missing_ok=True)


def play_trained(run: Path, *, folder: Path) -> dict:
    """Evaluate a run folder and its policy file, which hold the same policies, and return the outcomes of each."""
    file = run / "policy.safetensors"
    found = evaluation({"driver": (run, file), "pedestrians": (file,), "episodes": (128,)}, folder=folder)["outcomes"]
    return {name: found[f"{path} among {file}"] for name, path in (("run folder", run), ("policy file", file))}


def resume_trained(run: Path, *, folder: Path) -> list[dict]:
    """Resume a copy of a run folder and return the lines of metrics.jsonl."""
    copy = Path(tempfile.mkdtemp(dir=folder)) / "run"
    shutil.copytree(run, copy)
    jaxwalk("train", "--resume", copy, folder=folder)
    return metrics(copy)


def write(path: Path, document: object) -> None:
    """Write a compressed JSON file whose bytes depend on the document alone."""
    text = json.dumps(rounded(document), separators=(",", ":")) + "\n"
    path.write_bytes(gzip.compress(text.encode(), mtime=0))


def read(path: Path):
    """Read what `write` wrote."""
    return json.loads(gzip.decompress(path.read_bytes()))


def rounded(document):
    """The document with numbers of 8 digits, which are far more than are compared."""
    if isinstance(document, dict):
        return {name: rounded(x) for name, x in document.items()}
    if isinstance(document, list):
        return [rounded(x) for x in document]
    return float(f"{document:.8g}") if isinstance(document, float) else document


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], default=PARTS)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="jaxwalk-record-") as scratch:
        folder = Path(scratch)
        for part in options.parts or PARTS:
            begun = time.perf_counter()
            record(part, options.out.resolve(), folder)
            print(f"{part}: recorded in {time.perf_counter() - begun:.0f} s", flush=True)


def record(part: str, out: Path, folder: Path) -> None:
    """Write one part into a folder."""
    if part == "scenarios":
        hashes = [scenario_hash(*chosen, folder=folder) for chosen in SCENARIOS]
        write(out / "scenarios.json.gz", [[*chosen, found] for chosen, found in zip(SCENARIOS, hashes, strict=True)])
    elif part == "evaluations":
        for name in EVALUATIONS:
            write(evaluation_file(out, name), evaluation(EVALUATIONS[name], folder=folder))
    elif part == "updates":
        for name in TRAININGS:
            write(updates_file(out, name), updates(TRAININGS[name], folder=folder))
    else:
        shutil.rmtree(out / "trained", ignore_errors=True)
        make_trained(out / "trained", folder=folder)
        played, resumed = play_trained(out / "trained", folder=folder), resume_trained(out / "trained", folder=folder)
        for note in (out / "trained").rglob("commit_success.txt"):
            note.unlink()  # it holds nothing but paths of the machine that recorded
        write(out / "trained.json.gz", {"outcomes": played, "resumed": resumed})


def evaluation_file(out: Path, name: str) -> Path:
    """The file of an evaluation."""
    return out / f"evaluation-{name}.json.gz"


def updates_file(out: Path, name: str) -> Path:
    """The file of a training's first updates."""
    return out / f"updates-{name.replace(' ', '-')}.json.gz"


if __name__ == "__main__":
    main()

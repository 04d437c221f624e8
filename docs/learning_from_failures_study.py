"""The study of docs/learning-from-failures.md: does a car that trains on failures touch fewer people afterwards?

    python docs/learning_from_failures_study.py --out runs/learning

It goes on where it was interrupted: what is in the folder is not made again. With every training seed:

plain/SEED       a car trained alone in the world `town`, among people who always go
seen/SEED        failures of that car on the streets of its training, found by MAP-Elites
unseen/SEED      failures of the same car, found by another search; nobody trains on them
ordinary/SEED    as many ordinary scenarios as there are in `seen`
mixed/SEED       a car trained as the first one, but a share of its episodes begin with the failures in `seen`
repeated/SEED    the same with `ordinary` in place of `seen`: what the repetition of few scenarios does by itself
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from jaxwalk import resume, train
from jaxwalk.evaluation import Match, evaluate_grid, over_training_seeds, paired_delay, paired_over_seeds
from jaxwalk.evaluation.results import Results
from jaxwalk.experiments.tournament import Scenarios, play_rounds, results_of
from jaxwalk.interfaces import Policy
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.policies.pedestrians import AlwaysGo
from jaxwalk.provenance import provenance
from jaxwalk.recipes import RECIPES, Experiment, single_agent, with_training
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import Run
from jaxwalk.runs.street import make_street, shared_out
from jaxwalk.runs.training import is_finished
from jaxwalk.scenarios.archive_file import SCENARIOS, read_archive, write_archive
from jaxwalk.scenarios.archived import Archived
from jaxwalk.search import cube
from jaxwalk.search.driving import Driving
from jaxwalk.search.hunt import begun, method_of, play_generation
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import dimensions
from jaxwalk.writing import write_whole

UNSEEN_STREETS = "test:200"
PEOPLE = {"always-go": AlwaysGo()}
CARS = {"mixed": "seen", "repeated": "ordinary"}
"""The cars that train on kept scenarios, and on which ones."""
OTHER = "plain, next seed"
ENDINGS = ("moving contact", "goal")
SEARCHES = {"seen": 0, "unseen": 500}
"""What is added to the training seed for the seed of each search."""
FEWEST = 2
"""Fewest training seeds: on an archive, cars are compared with a plain car of another seed."""


def trained(folder: Path, experiment: Experiment, seed: int) -> Path:
    """Train, or go on with a training, or find it finished; return its folder. Ctrl-C ends the study."""
    begun = (folder / "config.json").is_file()
    if begun and is_finished(Run.open(folder)):
        return folder
    ended = resume(folder) if begun else train(shared_out(experiment), folder, seed=seed)
    if ended.interrupted:
        raise SystemExit(f"{folder}: interrupted; the same command goes on")
    return folder


def searched(file: Path, street: Street, driver: Policy, seed: int, simulations: int) -> Path:
    """Write a failure of each kind that a search finds; return the file."""
    if file.is_file():
        return file
    game = Driving(street, {"driver": driver, "pedestrian": PEOPLE["always-go"]}, seed)
    method = method_of("map-elites", game)
    hunt = begun(game, method)
    while hunt.simulations < simulations:
        play_generation(game, method, hunt, seed)
    found = hunt.elites.candidates.some(hunt.elites.best_failures)
    if not len(found):
        raise SystemExit(f"{file}: no failure in {hunt.simulations:,} scenarios; ask for more --simulations")
    print(f"{file}: {len(found)} kinds of failure in {hunt.simulations:,} scenarios", flush=True)
    return kept(file, street, found.points, found.keys, seed)


def kept(file: Path, street: Street, points: np.ndarray, keys: np.ndarray, seed: int) -> Path:
    """Write scenarios, in which everybody is there; return the file."""
    there = np.ones((len(points), street.config.pedestrians), bool)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_archive(file, Archived(street, points, there, seed, keys), {})
    return file


def ordinary(file: Path, street: Street, count: int, seed: int) -> Path:
    """Write that number of ordinary scenarios; return the file."""
    if file.is_file():
        return file
    points = cube.ordinary(np.random.default_rng(seed), count, dimensions(street.world))
    return kept(file, street, points, np.arange(count), seed)


def make_cars(out: Path, base: Experiment, asked: argparse.Namespace) -> None:
    """Make all trainings and searches."""
    street = make_street(base)
    for seed in asked.training_seeds:
        plain = contestant(street, "driver", str(trained(out / "plain" / str(seed), base, seed)))
        files = {
            name: searched(out / name / str(seed) / SCENARIOS, street, plain, seed + more, asked.simulations)
            for name, more in SEARCHES.items()
        }
        count = len(read_archive(files["seen"]))
        files["ordinary"] = ordinary(out / "ordinary" / str(seed) / SCENARIOS, street, count, seed)
        for car, of in CARS.items():
            mixing = replace(base, archives=(str(files[of].absolute()),), archive_share=asked.share)
            trained(out / car / str(seed), mixing, seed)


def on_drawn_scenarios(out: Path, base: Experiment, asked: argparse.Namespace) -> tuple[Results, dict[str, Any]]:
    """Play new scenarios on streets that no car has seen; return the results, and what was compared."""
    street = Street.create((UNSEEN_STREETS,), base.sim)
    rounds: list[Any] = [(None, {"clearance": contestant(street, "driver", "clearance")}, PEOPLE)]
    for seed in asked.training_seeds:
        cars = {name: contestant(street, "driver", str(out / name / str(seed))) for name in ("plain", *CARS)}
        rounds.append((seed, cars, PEOPLE))
    chosen, matches = play_rounds(street, rounds, Scenarios(asked.episodes, asked.seed), say=print)
    names = ("clearance", "plain", *CARS)
    of = {name: [match for match in matches if match.cell.driver == name] for name in names}
    pairs = [paired_over_seeds(ending, of[other], of["mixed"]) for ending in ENDINGS for other in ("plain", "repeated")]
    ordered: list[Match] = [match for group in of.values() for match in group]
    results = replace(results_of(street, chosen, ordered, paired=pairs), over_seeds=over_training_seeds(ordered))
    return results, {"delays": [asdict(paired_delay(of[other], of["mixed"])) for other in ("plain", "repeated")]}


def on_archives(out: Path, asked: argparse.Namespace) -> list[dict[str, Any]]:
    """Play each search's failures with the cars of its seed, and with the plain car of the next one.

    They were chosen because the plain car of their seed fails in them. Any other car fails in fewer, whatever it
    trained on: so it is the plain car of another seed that the others are compared with.
    """
    seeds, rows = asked.training_seeds, []
    for at, seed in enumerate(seeds):
        cars = {name: out / name / str(seed) for name in ("plain", *CARS)}
        cars[OTHER] = out / "plain" / str(seeds[(at + 1) % len(seeds)])
        for name in SEARCHES:
            archived = read_archive(out / name / str(seed))
            drivers = {car: contestant(archived.street, "driver", str(path)) for car, path in cars.items()}
            _, played = evaluate_grid(archived.street, drivers, PEOPLE, archived)
            touched = {car: int(touched_while_moving(of).sum()) for (car, _), of in played.items()}
            rows.append({"archive": name, "seed": seed, "scenarios": len(archived), "touched": touched})
    return rows


def shares(rows: list[dict[str, Any]], archive: str, car: str) -> np.ndarray:
    """Return for each seed the share of an archive's scenarios in which the moving car touches somebody [%]."""
    return np.array([100 * row["touched"][car] / row["scenarios"] for row in rows if row["archive"] == archive])


def interval(each: np.ndarray) -> str:
    """Return the mean over seeds with its 95 % t-interval, in words."""
    half = stats.t.ppf(0.975, len(each) - 1) * each.std(ddof=1) / np.sqrt(len(each))
    return f"{each.mean():.1f} [{each.mean() - half:.1f}, {each.mean() + half:.1f}] points"


def made_once(file: Path, make: Callable[[], Any]) -> Any:
    """Return a document, which is made if it isn't there."""
    if not file.is_file():
        write_whole(file, json.dumps(make(), indent=1) + "\n")
    return json.loads(file.read_text())


def say(drawn: dict[str, Any], archives: list[dict[str, Any]]) -> None:
    """Print the tables of the page."""
    for one in drawn["over_seeds"]:
        contacts, delay = one["moving_contact_rate"], one["mean_delay"]
        print(one["driver"], "contacts", contacts["mean"], contacts["each"], "delay", delay["mean"])
    for one in drawn["paired"]:
        print("mixed -", one["a"]["driver"], one["ending"], one["difference"], "p", one["p"])
    for one in drawn["delays"]:
        print("mixed -", one["a"], "delay", one["difference"], "p", one["p"])
    for name in SEARCHES:
        mine = [row for row in archives if row["archive"] == name]
        scenarios = sum(row["scenarios"] for row in mine)
        pooled = {car: sum(row["touched"][car] for row in mine) / scenarios for car in mine[0]["touched"]}
        print(name, f"{scenarios} scenarios", {car: f"{100 * share:.1f} %" for car, share in pooled.items()})
        for other in (OTHER, "repeated"):
            print(name, f"mixed - {other}:", interval(shares(archives, name, "mixed") - shares(archives, name, other)))
    print("mixed, unseen - seen:", interval(shares(archives, "unseen", "mixed") - shares(archives, "seen", "mixed")))


def main() -> None:
    """Train, search, train with what was found, and compare."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--out", type=Path, default=Path("runs/learning"))
    options.add_argument("--seeds", type=int, default=5, help="training seeds 70, 71, ...; nothing was tuned on them")
    options.add_argument("--updates", type=int, default=120)
    options.add_argument("--people", type=int, default=12)
    options.add_argument("--simulations", type=int, default=4096, help="scenarios of each search")
    options.add_argument("--share", type=float, default=0.25, help="of episodes that begin with a failure")
    options.add_argument("--episodes", type=int, default=5000, help="new scenarios for each car")
    options.add_argument("--seed", type=int, default=97, help="of the new scenarios")
    asked = options.parse_args()
    if asked.seeds < FEWEST:
        options.error(f"--seeds must be at least {FEWEST}")
    asked.training_seeds = range(70, 70 + asked.seeds)
    plan = {name: value for name, value in vars(asked).items() if name not in ("out", "training_seeds")}
    asked.out.mkdir(parents=True, exist_ok=True)
    if made_once(asked.out / "plan.json", lambda: plan) != plan:
        raise SystemExit(f"{asked.out}: is of another plan; name another folder")
    town = RECIPES["town"]
    base = replace(single_agent(town), crowds=(), sim=replace(town.sim, pedestrians=asked.people))
    base = with_training(base, updates=asked.updates)
    make_cars(asked.out, base, asked)

    def drawn() -> dict[str, Any]:
        results, compared = on_drawn_scenarios(asked.out, base, asked)
        return results.as_dict() | compared

    archives = made_once(asked.out / "archives.json", lambda: {"rows": on_archives(asked.out, asked)})["rows"]
    say(made_once(asked.out / "drawn.json", drawn), archives)
    print(json.dumps(asdict(provenance())))


if __name__ == "__main__":
    main()

"""The study of docs/failure-search.md: how many kinds of failure does each method find at an equal budget?

    python docs/failure_search_study.py --out runs/failure-search.json

It goes on where it was interrupted: what is in the file is not played again. At the end it prints the page's table.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.metrics import bootstrap_by_episode
from jaxwalk.provenance import provenance
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.search.driving import Driving
from jaxwalk.search.found_failures import AVOIDERS, PLAUSIBLE
from jaxwalk.search.grid import GRID
from jaxwalk.search.hunt import MethodName, begun, method_of, play_generation
from jaxwalk.search.judging import judge
from jaxwalk.sim.environment import Street
from jaxwalk.sim.suites import SUITES
from jaxwalk.writing import write_whole

METHODS: tuple[MethodName, ...] = ("random", "map-elites", "cross-entropy", "evolution")


def search(street: Street, policies: dict[str, Any], method: MethodName, seed: int, simulations: int) -> dict[str, Any]:
    """Return what one search finds: failures, kinds, and how many kinds are plausible and avoidable."""
    game = Driving(street, policies, seed)
    proposer = method_of(method, game)
    hunt = begun(game, proposer)
    while hunt.simulations < simulations:
        play_generation(game, proposer, hunt, seed)
    failed = hunt.elites.best_failures
    found, plausible = hunt.elites.candidates.some(failed), hunt.elites.quality[failed] > PLAUSIBLE
    when_seen = from_start = np.zeros(0, "U11")
    if len(found):
        verdict = judge(game, found, game.play(found).moments)
        when_seen, from_start = verdict.when_seen, verdict.from_start
    avoidable = np.isin(when_seen, AVOIDERS) | np.isin(from_start, AVOIDERS)
    return {
        "method": method,
        "seed": seed,
        **asdict(hunt.log[-1]),
        "log": [row.cells for row in hunt.log],
        "plausible": int(plausible.sum()),
        "avoidable": int(avoidable.sum()),
        "both": int((plausible & avoidable).sum()),
        "human": int((when_seen == "human").sum()),
        "percentiles": hunt.elites.quality[failed].round(2).tolist(),
    }


def summary(searches: list[dict[str, Any]], methods: Sequence[str], simulations: int) -> str:
    """Return the page's table in Markdown, how many times the kinds of chance each method finds, and its oddest one."""
    generations = len(searches[0]["log"])
    ends = [max(generations // part, 1) - 1 for part in (4, 2, 1)]
    budgets = [f"{simulations * (1 + end) // generations:,}" for end in ends]
    rows = [
        f"| method | kinds after {budgets[0]} scenarios | {budgets[1]} | {budgets[2]} | least to most | good "
        "| avoidable by the careful human, from when the person was seen | failures per 1,000 scenarios |",
        "| --- " * 8 + "|",
    ]
    of = {name: [one for one in searches if one["method"] == name] for name in methods}
    for name, mine in of.items():
        after = np.array([one["log"] for one in mine])[:, ends].mean(axis=0)
        cells = [one["cells"] for one in mine]
        good, human = (np.mean([one[column] for one in mine]) for column in ("both", "human"))
        rate = 1000 * sum(one["failures"] for one in mine) / sum(one["simulations"] for one in mine)
        means = " | ".join(f"{mean:.1f}" for mean in after)
        rows.append(f"| `{name}` | {means} | {min(cells)} to {max(cells)} | {good:.1f} | {human:.1f} | {rate:.1f} |")
    seeds = {name: {one["seed"]: one["cells"] for one in mine} for name, mine in of.items()}
    for name in (name for name in methods if name != "random" and "random" in methods):
        both = sorted(seeds[name].keys() & seeds["random"].keys())
        cells, chance = (np.array([seeds[method][seed] for seed in both]) for method in (name, "random"))
        ratio = bootstrap_by_episode(cells, chance)  # its unit is a seed here
        rows.append(
            f"{name}: {_number(ratio.value)} times the kinds of random "
            f"[{_number(ratio.low)}, {_number(ratio.high)}] (bootstrap over {len(both)} seeds, 95 %)"
        )
    for name, mine in of.items():
        percentiles = [percentile for one in mine for percentile in one["percentiles"]]
        odd = f"{min(percentiles):.2f}" if percentiles else "none, nothing failed"
        rows.append(f"{name}: percentile of the oddest failure: {odd}")
    return "\n".join(rows)


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.1f}"


def main() -> None:
    """Search with every method and seed, and say what was found."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--suite", default="town", choices=SUITES)
    options.add_argument("--driver", default="co-trained")
    options.add_argument("--pedestrians", default="always-go")
    options.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    options.add_argument("--simulations", type=int, default=4096)
    options.add_argument("--seeds", type=int, default=10, help="seeds 0, 1, ...; nothing was tuned on them")
    options.add_argument("--out", type=Path, default=Path("runs/failure-search.json"))
    asked = options.parse_args()
    street = world_of([asked.driver], SUITES[asked.suite])
    policies = {
        "driver": contestant(street, "driver", asked.driver),
        "pedestrian": contestant(street, "pedestrian", asked.pedestrians),
    }
    plan = {name: getattr(asked, name) for name in ("suite", "driver", "pedestrians", "simulations")} | {"grid": GRID}
    plan["origin"] = json.loads(json.dumps(asdict(policy_origin("driver", asked.driver))))
    document = json.loads(asked.out.read_text()) if asked.out.exists() else {"plan": plan, "searches": []}
    if document["plan"] != plan:
        raise SystemExit(f"{asked.out}: is of another plan; name another file")
    done = {(one["method"], one["seed"]) for one in document["searches"]}
    for seed in range(asked.seeds):
        for method in (name for name in asked.methods if (name, seed) not in done):
            found = search(street, policies, method, seed, asked.simulations)
            document["searches"].append(found | {"made": asdict(provenance())})
            print({name: found[name] for name in ("method", "seed", "failures", "cells", "both", "human")}, flush=True)
            asked.out.parent.mkdir(parents=True, exist_ok=True)
            write_whole(asked.out, json.dumps(document, indent=1) + "\n")
    print(summary(document["searches"], asked.methods, asked.simulations))


if __name__ == "__main__":
    main()

"""The study of docs/failure-search.md: how many kinds of failure does each method find at an equal budget?

    python docs/failure_search_study.py --out runs/failure-search.json

It goes on where it was interrupted: what is in the file is not played again.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.provenance import provenance
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.search.driving import Driving
from jaxwalk.search.found_failures import AVOIDERS, PLAUSIBLE
from jaxwalk.search.grid import GRID
from jaxwalk.search.hunt import begun, method_of, play_generation
from jaxwalk.search.judging import judge
from jaxwalk.sim.environment import Street
from jaxwalk.sim.suites import SUITES
from jaxwalk.writing import write_whole

METHODS = ("random", "map-elites", "cross-entropy", "evolution")


def search(street: Street, policies: dict[str, Any], method: str, seed: int, simulations: int) -> dict[str, Any]:
    """Return what one search finds: failures, kinds, and how many kinds are plausible and avoidable."""
    game = Driving(street, policies, seed)
    proposer = method_of(method, game)
    hunt = begun(game, proposer)
    while hunt.simulations < simulations:
        play_generation(game, proposer, hunt, seed)
    failed = hunt.elites.found
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
    for method in asked.methods:
        mine = [one for one in document["searches"] if one["method"] == method]
        cells, good = (np.array([one[name] for one in mine]) for name in ("cells", "both"))
        failures = np.array([one["failures"] for one in mine])
        print(
            f"{method}, {len(mine)} seeds: {cells.mean():.1f} kinds ({cells.min()} to {cells.max()}), "
            f"{good.mean():.1f} plausible and avoidable, "
            f"{1000 * failures.mean() / asked.simulations:.2f} failures per 1,000 scenarios"
        )


if __name__ == "__main__":
    main()

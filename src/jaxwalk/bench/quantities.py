"""Figures from measured rows: each has a name, a unit and one sentence. What was not measured has no figure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

Rows = Mapping[str, Sequence[Mapping[str, Any]]]
"""Measured rows, by name: see `jaxwalk.bench.document`."""
LARGE = 16384
"""A large number of environments: data that fit into the cache for fewer are in memory here."""
Value = float | int | None
"""None if the measurements don't give the value."""

FIGURES: dict[str, tuple[str, str]] = {
    "env_steps_per_s": ("steps/s", "The simulator alone, all observations and rewards computed, at its best size."),
    "env_steps_per_s_paper_observations": ("steps/s", "The same with the paper's two observation sets alone."),
    "env_steps_per_s_at_16384": ("steps/s", "All observations again, with 16,384 environments."),
    "env_share_at_16384": ("share", "That as a share of the best size's."),
    "env_temporary_memory_ratio": ("ratio", "Temporary memory over state and what the rollout keeps; the worst size."),
    "memory_environments_nonlinearity": ("share", "Farthest that any size's memory lies from a straight line."),
    "train_steps_per_s_fast": ("steps/s", "Steps of all environments in training, recipe fast at its own size."),
    "train_steps_per_s_fast_best": ("steps/s", "The same at its best number of environments."),
    "train_steps_per_s_fast_single_agent": ("steps/s", "Recipe fast, the car alone."),
    "train_steps_per_s_paper": ("steps/s", "Recipe paper at its own size."),
    "train_steps_per_s_paper_best": ("steps/s", "The same at its best number of environments."),
    "agent_transitions_per_s_fast": ("transitions/s", "Steps of every learning agent, recipe fast."),
    "agent_transitions_per_s_paper": ("transitions/s", "Steps of every learning agent, recipe paper."),
    "flop_per_step_fast": ("FLOP", "What the networks cost for each environment step, by formula, recipe fast."),
    "flop_per_step_paper": ("FLOP", "The same, recipe paper."),
    "matmul_peak_flops": ("FLOP/s", "The best square matrix product, between and after the trainings."),
    "matmul_peak_flops_highest": ("FLOP/s", "The same with all bits of 32-bit numbers; accelerators only."),
    "share_of_peak_fast": ("share", "The networks' operations per second over that peak, recipe fast."),
    "share_of_peak_paper": ("share", "The same, recipe paper."),
    "best_share_of_peak_fast": (
        "share",
        "The same of the quickest update, recipe fast: the peak is the quickest, too.",
    ),
    "best_share_of_peak_paper": ("share", "The same of the quickest update, recipe paper."),
    "peak_memory_train_fast": ("B", "The most memory that training took, recipe fast at its own size."),
    "peak_memory_train_paper": ("B", "The same, recipe paper."),
    "import_s": ("s", "python -c 'import jaxwalk'."),
    "help_s": ("s", "jaxwalk --help."),
    "first_update_cold_s": ("s", "From jaxwalk train to the end of its first update, nothing compiled before."),
    "first_update_warm_s": ("s", "The same with the first one's compiled code, the median of three."),
    "best_first_update_warm_s": ("s", "The quickest of the three."),
    "train_command_cold_s": ("s", "The whole command with that one update: checkpoint and policy written."),
    "train_command_warm_s": ("s", "The same with the first one's compiled code, the median of three."),
    "pedestrian_time_exponent": ("exponent", "A step's time grows with pedestrians to this power."),
    "pedestrian_memory_exponent": (
        "exponent",
        "An environment's temporary memory grows with pedestrians to this power.",
    ),
    "env_share_64_streets": ("share", "The simulator on 64 generated streets, of its speed on one; in turns."),
    "env_share_256_streets": ("share", "The same on 256 streets, of its speed on 64."),
    "env_share_64_streets_no_rays": ("share", "On 64 streets, without the rays of the set surroundings."),
    "env_share_256_streets_no_rays": ("share", "The same on 256 streets, of its speed on 64."),
    "bytes_per_street": ("B", "The tables of a generated street; the largest of all rows."),
    "train_share_town": ("share", "Training with recipe town, of the speed of recipe fast; in turns."),
    "env_share_paper_24": ("share", "The simulator on the paper's street: 24 people, of its speed with 12; in turns."),
    "env_share_town_12": ("share", "The simulator in the suite town with 12 people, of the same speed."),
    "env_share_town_24": ("share", "There with 24 people."),
    "env_share_blind_corner_12": (
        "share",
        "The simulator in the suite blind-corner with 12 people, of the same speed.",
    ),
    "env_share_blind_corner_24": ("share", "There with 24 people."),
    "env_share_arterial_12": ("share", "The simulator in the suite arterial with 12 people, of the same speed."),
    "env_share_arterial_24": ("share", "There with 24 people."),
}
"""Unit and meaning of every figure, in the order of display."""


def figures(rows: Rows) -> dict[str, dict[str, Any]]:
    """Return all figures that can be computed from the rows."""
    values: dict[str, Value] = {}
    for name, compute in PARTS.items():
        if rows.get(name):
            values |= compute(rows[name])
    values |= _shares(values)
    found = ((name, values.get(name), unit, what) for name, (unit, what) in FIGURES.items())
    return {
        name: {"value": value, "unit": unit, "what": what} for name, value, unit, what in found if value is not None
    }


def exponent(x: Sequence[float | int], y: Sequence[float | int]) -> float | None:
    """Return the slope of log y over log x by least squares; None without two different x."""
    if len(set(x)) < 2:
        return None
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def nonlinearity(x: Sequence[float | int], y: Sequence[float | int]) -> float | None:
    """Return the largest relative distance of y from a + b x, fitted to relative distances; None for fewer than 3 x."""
    if len(set(x)) < 3:
        return None
    y_, columns = np.asarray(y, float), np.stack([np.ones(len(x)), np.asarray(x, float)], axis=1)
    fitted, *_ = np.linalg.lstsq(columns / y_[:, None], np.ones(len(x)), rcond=None)
    return float(np.max(np.abs(columns @ fitted / y_ - 1)))


def memory(row: Mapping[str, Any]) -> int:
    """Return the memory of a rollout of the simulator alone: its inputs, and what it holds while it runs [B]."""
    return row["state_bytes"] + row["temporary_bytes"]


def microseconds(row: Mapping[str, Any]) -> float:
    """Return the time of one step of one environment [us] in the fastest call: a disturbed call distorts a slope."""
    return 1e6 / row["best_env_steps_per_s"]


def _simulator(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    papers = [row["env_steps_per_s"] for row in rows if row["observations"] == "paper"]
    rows = [row for row in rows if row["observations"] == "every"]
    best = max(row["env_steps_per_s"] for row in rows)
    large = next((row["env_steps_per_s"] for row in rows if row["environments"] == LARGE), None)
    return {
        "env_steps_per_s": best,
        "env_steps_per_s_paper_observations": max(papers, default=None),
        f"env_steps_per_s_at_{LARGE}": large,
        f"env_share_at_{LARGE}": None if large is None else large / best,
        "env_temporary_memory_ratio": max(
            row["temporary_bytes"] / (row["state_bytes"] + row["kept_bytes"]) for row in rows
        ),
        "memory_environments_nonlinearity": nonlinearity(
            [row["environments"] for row in rows], [memory(row) for row in rows]
        ),
    }


def _training(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    """Return the figures of a recipe. Its first row is the one at its own size."""
    values: dict[str, Value] = {}
    for recipe in ("fast", "paper"):
        together = [row for row in rows if row["recipe"] == recipe and not row["single_agent"]]
        if not together:
            continue
        own = together[0]
        values[f"train_steps_per_s_{recipe}"] = own["train_steps_per_s"]
        values[f"best_train_steps_per_s_{recipe}"] = own["best_train_steps_per_s"]
        values[f"agent_transitions_per_s_{recipe}"] = own["agent_transitions_per_s"]
        values[f"flop_per_step_{recipe}"] = own["flop_per_step"]
        values[f"peak_memory_train_{recipe}"] = own.get("peak_memory_bytes")
        if len(together) > 1:
            values[f"train_steps_per_s_{recipe}_best"] = max(row["train_steps_per_s"] for row in together)
    alone = [row["train_steps_per_s"] for row in rows if row["single_agent"]]
    return values | {"train_steps_per_s_fast_single_agent": alone[0] if alone else None}


def _products(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    """Return the peak. With TF32 products, an accelerator's peak is that of those products."""
    best = {
        precision: max((row["flops"] for row in rows if row["precision"] == precision), default=None)
        for precision in ("default", "highest")
    }
    return {"matmul_peak_flops": best["default"], "matmul_peak_flops_highest": best["highest"]}


def _starts(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    return {row["name"]: row["seconds"] for row in rows}


def _crowd(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    people = [row["pedestrians"] for row in rows]
    return {
        "pedestrian_time_exponent": exponent(people, [microseconds(row) for row in rows]),
        "pedestrian_memory_exponent": exponent(people, [row["temporary_bytes"] for row in rows]),
    }


def _streets(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    speeds = {(row["observations"], row["streets"]): row["env_steps_per_s"] for row in rows}
    shares = {
        f"env_share_{n}_streets{suffix}": _ratio(speeds.get((seen, n)), speeds.get((seen, fewer)))
        for seen, suffix in (("every", ""), ("no rays", "_no_rays"))
        for n, fewer in ((64, 1), (256, 64))
    }
    return {
        **shares,
        "bytes_per_street": max(row["bytes_per_street"] for row in rows),
    }


def _trained_in_turns(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    speeds = {row["recipe"]: row["train_steps_per_s"] for row in rows}
    return {"train_share_town": _ratio(speeds.get("town"), speeds.get("fast"))}


def _suites(rows: Sequence[Mapping[str, Any]]) -> dict[str, Value]:
    return {
        f"env_share_{row['suite'].replace('-', '_')}_{row['pedestrians']}": float(np.median(row["share_of_paper"]))
        for row in rows
    }


def _ratio(speeds: Sequence[float] | None, others: Sequence[float] | None) -> float | None:
    """Return the median ratio of the speeds of two programs that took turns; None if one wasn't measured."""
    return None if not speeds or not others else float(np.median(np.divide(speeds, others)))


def _shares(values: Mapping[str, Value]) -> dict[str, float]:
    """Return the shares of the peak."""
    peak, shares = values.get("matmul_peak_flops"), {}
    for recipe in ("fast", "paper"):
        cost = values.get(f"flop_per_step_{recipe}")
        for share, name in (("share_of_peak", "train_steps_per_s"), ("best_share_of_peak", "best_train_steps_per_s")):
            rate = values.get(f"{name}_{recipe}")
            if peak and rate and cost:
                shares[f"{share}_{recipe}"] = rate * cost / peak
    return shares


PARTS: dict[str, Callable[[Sequence[Mapping[str, Any]]], dict[str, Value]]] = {
    "env": _simulator,
    "training": _training,
    "products": _products,
    "starts": _starts,
    "pedestrians": _crowd,
    "streets": _streets,
    "train-streets": _trained_in_turns,
    "suites": _suites,
}
"""The function that computes the figures of each list of rows."""

"""Raters whose preferences are known: they answer as Davidson's model says, each pair by itself."""

from __future__ import annotations

import json
from dataclasses import asdict
from itertools import combinations
from pathlib import Path

import numpy as np

from jaxwalk.evaluation.document_parts import ScenarioSet
from jaxwalk.provenance import Provenance
from jaxwalk.raters.answer_files import RaterAnswer, RaterFile
from jaxwalk.raters.rating_plan import SCHEMA, DriverMeasure, RatedPair, RatingPlan

CLIPS = 3
"""Pairs of clips for every two drivers."""
CHECKS = 2
TIES = 0.5
"""Davidson's nu: of two alike drivers, one answer in five is a tie."""


def a_plan(drivers=7, *, each=25, measures=(), seed=0):
    """A plan in which every two drivers are rated in as many scenarios."""
    rng = np.random.default_rng(seed)
    pairs = []
    for scenario, (a, b) in enumerate(list(combinations(range(drivers), 2)) * CLIPS):
        first, second = (a, b) if rng.random() < 0.5 else (b, a)
        pairs.append(RatedPair(scenario, first, second, 1.0))
    pairs += [RatedPair(1000 + k, k % drivers, drivers, 2.0, "a") for k in range(CHECKS)]
    names = tuple(f"driver-{k}" for k in range(drivers))
    return RatingPlan(
        drivers=names, players=(*names, "blind"), pedestrians="always-go",
        scenarios=ScenarioSet(200, "0123456789abcdef", seed), seed=seed, each=each, pairs=tuple(pairs),
        measures=tuple(measures), made=Provenance(None, "an abacus", {}),
    )  # fmt: skip


def measure(name, values, *, high=True):
    return DriverMeasure(name, high, tuple(map(float, values)))


def files(plan, strengths, raters, rng, *, repeats=3, attentive=True):
    """What raters send who find the drivers as strong as that; ``strengths`` may differ, ``(rater, driver)``."""
    each = np.broadcast_to(strengths, (raters, len(plan.drivers)))
    return [_file(plan, each[k], rng, repeats, attentive) for k in range(raters)]


def write_files(folder: Path, plan, raters: int) -> None:
    """Write what raters send who find all drivers alike, as ``answers-0.json`` and so on."""
    sent = files(plan, np.zeros(len(plan.drivers)), raters, np.random.default_rng(0))
    for k, file in enumerate(sent):
        (folder / f"answers-{k}.json").write_text(json.dumps(asdict(file)))


def _file(plan, strengths, rng, repeats, attentive):
    shown = rng.permutation(plan.rated)[: plan.each].tolist()
    answers = [_answer(plan, pair, strengths, rng, repeat=False) for pair in shown]
    answers += [_answer(plan, pair, strengths, rng, repeat=True) for pair in shown[:repeats]]
    checks = [(place, pair.safer) for place, pair in enumerate(plan.pairs) if pair.safer]
    seen = "left" if attentive else "right"
    answers += [RaterAnswer(place, safer, seen, 5.0, False) for place, safer in checks]
    return RaterFile(SCHEMA, plan.id, rng.bytes(8).hex(), True, True, tuple(answers))


def _answer(plan, place, strengths, rng, *, repeat):
    pair = plan.pairs[place]
    a, b = strengths[pair.a], strengths[pair.b]
    weights = np.exp([a, b, (a + b) / 2]) * [1, 1, TIES]
    chosen = rng.choice(3, p=weights / weights.sum())
    left = "a" if rng.random() < 0.5 else "b"
    answer = "equal" if chosen == 2 else "left" if (chosen == 0) == (left == "a") else "right"
    return RaterAnswer(place, left, answer, round(float(rng.uniform(8, 20)), 1), repeat)

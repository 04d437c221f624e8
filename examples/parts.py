"""Evaluate in two parts, as two machines would, and merge them: the numbers are those of one evaluation of all.

Needs ``pip install "jaxwalk[data]"``. On the command line: ``jaxwalk evaluate --part K/N`` and ``jaxwalk merge``.
"""

from pathlib import Path

from jaxwalk import Street
from jaxwalk.evaluation.document_parts import EvaluationOptions
from jaxwalk.evaluation.parts import Part, read_part
from jaxwalk.evaluation.settings import jaywalk_multiplier
from jaxwalk.experiments.evaluating import Evaluation, evaluate_all
from jaxwalk.experiments.in_parts import evaluate_part, merge_parts
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.policies import AlwaysGo, RouteFollower

EPISODES = 1024  # two batches of 512; use 100,000 or more


def told(what: str, done: int, total: int) -> None:
    print(f"{what}: {done:,} of {total:,}")


street = Street.create()
work = Evaluation(
    streets=(street,),
    drivers={"route-follower": RouteFollower()},
    populations={"always-go": AlwaysGo()},
    scenarios=Scenarios(EPISODES, 0),
    options=EvaluationOptions((jaywalk_multiplier(street),)),
)
folders = [Path("parts", str(number)) for number in (1, 2)]
for number, folder in enumerate(folders, 1):
    evaluate_part(work, Part(number, 2), folder, told)  # on any machine, in any order

merged = merge_parts([read_part(folder) for folder in folders], Path("results"), told)
print(f"collisions of {merged.results.scenarios.count:,} episodes: {merged.results.cells[0].collision_rate.value:.2%}")
whole = evaluate_all(work, told)
assert merged.results.cells == whole.cells

"""The evaluation that options of ``jaxwalk evaluate`` ask for."""

from __future__ import annotations

from jaxwalk.cli.checks import place
from jaxwalk.cli.options import Evaluate
from jaxwalk.evaluation import jaywalk_multiplier
from jaxwalk.evaluation.document_parts import EvaluationOptions
from jaxwalk.experiments.evaluating import Evaluation, prepared
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.policies.shield_names import with_shield
from jaxwalk.runs.contestants import world_of
from jaxwalk.scenarios.archive_file import read_archive


def work_of(options: Evaluate) -> Evaluation:
    """Return what the options ask for, with all policies loaded."""
    compared = with_shield(options.compare, options.shield)
    drivers = tuple(dict.fromkeys((*with_shield(options.driver, options.shield), *compared)))
    populations = tuple(dict.fromkeys(options.pedestrians))
    kept = read_archive(options.scenarios) if options.scenarios else None
    street = world_of([*drivers, *populations], place(options)) if kept is None else kept.street
    asked = EvaluationOptions(
        jaywalk_multipliers=tuple(dict.fromkeys(options.jaywalk_multiplier or (jaywalk_multiplier(street),))),
        driver_acts=options.driver_acts,
        pedestrians_act=options.pedestrians_act,
        compare=(compared[0], compared[1]) if compared else None,
        counterfactuals=options.counterfactuals,
        encounters=options.encounters,
    )
    return prepared(
        street, (drivers, populations), kept or Scenarios(options.episodes, options.seed), asked,
        out=options.out, trust=options.trust, seconds=options.driver_seconds,
    )  # fmt: skip

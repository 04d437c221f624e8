"""How an option is written down, and what is raised when options don't make sense."""

from __future__ import annotations

from typing import Any

import tyro

from jaxwalk.runs.recipes import RECIPES

Flag = tyro.conf.FlagCreatePairsOff[bool]
"""An option without a value."""


class UsageError(ValueError):
    """Options that don't make sense; one line says why and what to do."""


def option(default: str, kind: str | None = None, name: str | None = None) -> Any:
    """How ``--help`` shows an option: its default in words, and what to write after it."""
    return tyro.conf.arg(help_behavior_hint=f"(default: {default})", metavar=kind, name=name)


def tuned(name: str, kind: str) -> Any:
    """An option that is a field of `TrainConfig`: its default is the recipe's."""
    values = ", ".join(f"{recipe} {getattr(experiment.train, name):g}" for recipe, experiment in RECIPES.items())
    return option(f"the recipe's: {values}", kind)

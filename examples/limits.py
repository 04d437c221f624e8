"""A training with a limit of contacts, much too short to learn: what is logged of the limit (docs/learning.md)."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes import RECIPES, single_agent, with_limits, with_training
from jaxwalk.runs.folder import Run
from jaxwalk.runs.training import train

fast = single_agent(with_limits(RECIPES["fast"], CostLimit("contact", limit=0.05, worth=15.0)))
small = replace(with_training(fast, environments=64, steps=64, minibatches=4, updates=12), seed=7)
with TemporaryDirectory() as folder:
    run = Run.create(Path(folder) / "run", small)
    train(run)
    for line in run.metrics()[::3]:
        cost, multiplier = line["cost/driver/contact"], line["multiplier/driver/contact"]
        print(f"update {line['update']}: {cost:.2f} contacts per episode, a multiplier of {multiplier:.4f}")

"""A training with a limit of contacts, much too short to learn: what is logged of the limit (docs/learning.md)."""

from jaxwalk import train
from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes import RECIPES, single_agent, with_limits, with_training

fast = single_agent(with_limits(RECIPES["fast"], CostLimit("contact", limit=0.05, worth=15.0)))
small = with_training(fast, environments=64, steps=64, minibatches=4)
for line in train(small, seed=7, updates=12).metrics[::3]:
    cost, multiplier = line["cost/driver/contact"], line["multiplier/driver/contact"]
    print(f"update {line['update']}: {cost:.2f} contacts per episode, a multiplier of {multiplier:.4f}")

"""A training with a limit of contacts, much too short to learn: what is logged of the limit (docs/learning.md)."""

from jaxwalk import train
from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes import RECIPES, single_agent, with_limits, with_training

fast = single_agent(with_limits(RECIPES["fast"], CostLimit("contact", limit=0.05, worth=15.0)))
small = with_training(fast, environments=64, steps=64, minibatches=4)


def tell(metrics):
    cost, multiplier = metrics["cost/driver/contact"], metrics["multiplier/driver/contact"]
    print(f"update {metrics['update']}: {cost:.2f} contacts per episode, a multiplier of {multiplier:.4f}")


train(small, seed=7, updates=12, on_update=tell)

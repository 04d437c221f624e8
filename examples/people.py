"""Test a driver among people of several kinds: each pedestrian is of one kind, in stated shares."""

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street, evaluate, summarise
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import Mixture

street = Street.create()
scenarios = Drawn(street, seed=0, count=64)  # use 2,000 or more for reliable numbers
kinds = {"diffusion": 0.5, "distracted": 0.3, "always-go": 0.2}
mixed = Mixture(tuple(POPULATIONS[name]() for name in kinds), tuple(kinds.values()))
for name, people in {"diffusion": POPULATIONS["diffusion"](), "mixed": mixed}.items():
    rows = evaluate(street, {"driver": DRIVERS["clearance"](), "pedestrian": people}, scenarios, batch=64)
    found = summarise(rows)[OUTCOMES]
    print(f"clearance among {name}: goals {found.goal.value:.0%}, collisions {found.collision.value:.0%}")

"""What does it cost a car that parked vehicles hide people? The same scenarios, with and without perception."""

from dataclasses import replace

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street, evaluate, summarise
from jaxwalk.metrics import OUTCOMES
from jaxwalk.sim.sim_config import WORLDS

world = replace(WORLDS["blind-corner"], pedestrians=24)
for name, rules in {"hidden": world, "all in sight": replace(world, perception=False)}.items():
    street = Street.create(["test:2"], rules)
    scenarios = Drawn(street, seed=0, count=64)  # use 2,000 or more for reliable numbers
    rows = evaluate(street, {"driver": DRIVERS["clearance"](), "pedestrian": POPULATIONS["always-go"]()}, scenarios)
    found = summarise(rows)[OUTCOMES]
    print(f"{name}: scenarios {scenarios.hash()}, goals {found.goal.value:.0%}, collisions {found.collision.value:.0%}")

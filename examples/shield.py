"""What does a shield do for a driver that acts at random? The same scenarios with and without it."""

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street, evaluate, summarise
from jaxwalk.evaluation.shield_effects import shield_effect
from jaxwalk.metrics import SHIELD_INTERVENTIONS
from jaxwalk.policies import shielded
from jaxwalk.sim.sim_config import WORLDS

street = Street.create(config=WORLDS["paper-footprint"])
scenarios = Drawn(street, seed=0, count=64)  # use 2,000 or more for reliable numbers
people = POPULATIONS["always-go"]()
driver = DRIVERS["random"]()

bare = evaluate(street, {"driver": driver, "pedestrian": people}, scenarios, batch=64)
for shield in ("predictive", "rss"):
    behind = evaluate(street, {"driver": shielded(driver, shield), "pedestrian": people}, scenarios, batch=64)
    print(shield_effect(("random", shield, "always-go"), 0.25, bare, behind, street.config.contact).in_words)
    print(f"  actions changed in {summarise(behind)[SHIELD_INTERVENTIONS].changed.value:.1%} of all steps")

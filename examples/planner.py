"""Is planning better than the clearance rule at equal delay? Both play the suite `blind-corner` (docs/drivers.md)."""

import sys
from dataclasses import replace

import numpy as np

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street, evaluate
from jaxwalk.metrics import OUTCOMES, paired_difference
from jaxwalk.metrics.delay import delays
from jaxwalk.policies.clearance_rule import ClearanceRule
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.suites import SUITES

episodes, seed = (int(x) for x in sys.argv[1:] or (64, 0))  # use 2,000 or more for reliable numbers
suite = SUITES["blind-corner"]
street = Street.create(suite.maps, replace(WORLDS["blind-corner"], pedestrians=suite.people))
scenarios = Drawn(street, seed, episodes)
print(f"{episodes} scenarios of seed {seed}, hash {scenarios.hash()}")

drivers = {f"clearance, {away} m": ClearanceRule(away) for away in (1.0, 1.25)}
drivers |= {name: DRIVERS[name]() for name in ("belief-planner", "belief-planner-chance", "belief-planner-cvar")}
found = {}
for name, driver in drivers.items():
    policies = {"driver": with_limits(driver, street.config), "pedestrian": POPULATIONS["always-go"]()}
    rows = evaluate(street, policies, scenarios)
    ends, delay = rows[OUTCOMES], np.nanmean(delays(rows))
    found[name] = {"collisions": ends.collision, "collisions of a moving car": ends.collision & ends.moving}
    print(f"{name}: goals {ends.goal.mean():.2%}, delay {delay:.2f} s")
    for what, mine in found[name].items():
        print(f"  {what} {mine.mean():.2%}")
        for other in [rule for rule in found if "planner" in name and "clearance" in rule]:
            more = paired_difference(found[other][what], mine)
            print(f"    beyond those of {other}: {more.value:+.1%} [{more.low:.1%}, {more.high:.1%}]")

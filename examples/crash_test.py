"""A crash test of your own: an adult steps out between parked cars and stops in the middle of the lane."""

from pathlib import Path
from tempfile import TemporaryDirectory

from jaxwalk import DRIVERS
from jaxwalk.evaluation.crash_outcomes import crash_test
from jaxwalk.policies import AlwaysGo
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.scenarios import Scripted

TESTS = """
name = "mine"
title = "My crash tests"
source = "examples/crash_test.py"

[[tests]]
name = "stops in the lane"
title = "an adult steps out between parked cars, and stops in front of the car"
speeds = [20, 30, 40]          # km/h
meets = { x = 130.0 }          # where the car's route crosses x = 130 m of the test track
passes = { impact = 0.0 }      # no contact

[[tests.people]]
path = [[0.0, -4.0], [0.0, 0.0]]  # ahead of that place and to its left [m]: from the right to the lane's middle
speed = 5.0                       # km/h
hit = 40.0                        # the unbraked car would hit with this place of its front [%, 0 at the right edge]

[[tests.parked]]
at = [-4.0, -2.8]

[[tests]]
name = "nobody"
title = "the same street without anybody"
speeds = [20, 30, 40]
meets = { x = 130.0 }
passes = { deceleration = 2.45, keeps = 0.8 }  # m/s2, and the share of the speed that is kept
"""

with TemporaryDirectory() as folder:
    file = Path(folder) / "mine.toml"
    file.write_text(TESTS)
    source = Scripted.load(file)

driver = with_limits(DRIVERS["careful-human"](), source.street.config)
for outcome in crash_test({"driver": driver, "pedestrian": AlwaysGo()}, source):
    impact = "no contact" if outcome.impact is None else f"contact at {outcome.impact:.0f} km/h"
    print(f"{outcome.test}, {outcome.speed:g} km/h: {outcome.result}, {impact}; passes: {outcome.passed}")

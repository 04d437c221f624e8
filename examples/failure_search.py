"""Search for failures from Python: kinds of contacts of a careful human, and how few people one of them takes."""

import numpy as np

from jaxwalk import DRIVERS, Street
from jaxwalk.policies import AlwaysGo
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.search.driving import Driving
from jaxwalk.search.grid import in_words
from jaxwalk.search.hunt import begun, method_of, play_generation
from jaxwalk.search.minimising import minimise
from jaxwalk.sim.sim_config import WORLDS

street = Street.create(("paper",), WORLDS["paper-footprint"])
driver = with_limits(DRIVERS["careful-human"](), street.config)
game = Driving(street, {"driver": driver, "pedestrian": AlwaysGo()}, seed=0, batch=64)

method = method_of("map-elites", game)
hunt = begun(game, method)
for _ in range(6):
    play_generation(game, method, hunt, seed=0)
print(f"{hunt.log[-1].cells} kinds of failure in {hunt.simulations} scenarios")

failures = hunt.elites.candidates.some(hunt.elites.best_failures)
played = game.play(failures)
for cell, percentile in zip(played.moments.cell[:3], played.percentiles[:3], strict=True):
    print(f"{in_words(int(cell))}; {percentile:.0f} % of ordinary scenarios are at least as unusual")

first = failures.some(slice(1))
minimal = minimise(game, first, played.moments.ped[:1], tell=lambda done: None)
print(f"{int(minimal.present.sum())} of {street.config.pedestrians} people are enough for the first one")
assert minimal.played.moments.failed.all() and np.all(minimal.played.moments.ped == played.moments.ped[:1])

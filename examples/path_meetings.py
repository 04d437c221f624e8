"""Measure what people do where their way meets a car's path: who stops, which gaps they accept, how near they pass."""

from jaxwalk import DRIVERS, POPULATIONS, Drawn, Street, summarise
from jaxwalk.evaluation import replay
from jaxwalk.metrics import measure
from jaxwalk.metrics.path_meetings import PATH_MEETINGS

street = Street.create()
policies = {"driver": DRIVERS["idm-yield"](), "pedestrian": POPULATIONS["gap-acceptance"]()}
episodes = replay(street, policies, Drawn(street, seed=0, count=32), range(32), batch=32)
found = summarise(measure(episodes, config=street.config, metrics=(PATH_MEETINGS,)))[PATH_MEETINGS]
print(f"{found.waited.count} meetings: {found.waited.value:.0%} of the people stopped before the car's path,")
print(f"{found.pedestrian_first.value:.0%} came first; median smallest distance {found.min_distance.value:.1f} m")

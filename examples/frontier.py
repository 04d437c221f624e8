"""Which settings of the clearance rule does another one beat in contacts and in delay, on the same scenarios?"""

from jaxwalk import POPULATIONS, Drawn, Street, evaluate
from jaxwalk.evaluation.frontier_scores import Contender, scores_of_rows, standings
from jaxwalk.policies.knobs import KNOBS
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim.sim_config import WORLDS

street = Street.create(config=WORLDS["paper-footprint"])
scenarios = Drawn(street, seed=0, count=64)  # use 2,000 or more for reliable numbers
people, knob = POPULATIONS["always-go"](), KNOBS["clearance"]

scores = []
for setting in (0.25, 1.0, 4.0):
    policies = {"driver": with_limits(knob.turned(setting), street.config), "pedestrian": people}
    rows = evaluate(street, policies, scenarios, batch=64)
    scores.append(scores_of_rows(Contender(knob.label("clearance", setting), "clearance"), rows))

for one, standing in zip(scores, standings(scores), strict=True):
    contacts, delay = one.contact_rate(), one.mean_delay()
    print(f"{one.contender.name}: contacts in {contacts.value:.1%}, delay {delay.value:.2f} s; {standing.verdict}")

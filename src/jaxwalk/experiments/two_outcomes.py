"""Choose the two episodes of the paper's figure 1 by fixed rules: a jaywalker is hit, and a jaywalker is avoided."""

from __future__ import annotations

from dataclasses import replace

from jaxwalk.evaluation import evaluate
from jaxwalk.exports.gallery import Cast
from jaxwalk.metrics import ENCOUNTERS, OUTCOMES
from jaxwalk.report import CO_TRAINED, LEARNED, ROUTE_FOLLOWER, SINGLE_AGENT, DrawnEpisode, Gallery
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import JAYWALK

INTERESTING = 200
"""Number of scenarios in which an avoided jaywalker is sought."""


def two_outcomes(cast: Cast, watched: Gallery, *, episodes: int, training_seed: int) -> dict[str, DrawnEpisode]:
    """Return the episodes by the names of their files: ``collision``, unless nobody was hit, and ``episode``."""
    chosen = {"collision": jaywalker_hit(watched), "episode": _jaywalker_avoided(cast, min(INTERESTING, episodes))}
    return {
        name: replace(drawn, seed=cast.seed, training_seed=training_seed) for name, drawn in chosen.items() if drawn
    }


def jaywalker_hit(watched: Gallery) -> DrawnEpisode | None:
    """Return the end of the gallery's fastest collision with a jaywalker, of the first driver that has one.

    The co-trained car comes first, then the car trained alone, then the one that heeds nobody.
    """
    hits = [x for x in watched.incidents if (x.kind, x.contact, x.moving) == ("collision", "jaywalk", True)]
    for driver in (CO_TRAINED, SINGLE_AGENT, ROUTE_FOLLOWER):
        found = [x for x in hits if watched.episodes[x.episode].driver == driver]
        if found:
            worst = watched.episodes[max(found, key=lambda x: x.speed or 0.0).episode]
            return DrawnEpisode(worst.scenario, 0, 0, worst.steps, driver, worst.pedestrians)
    return None


def _jaywalker_avoided(cast: Cast, episodes: int) -> DrawnEpisode:
    """Return the start of the nearest encounter of the co-trained car that arrives with a learned jaywalker."""
    policies = {"driver": cast.drivers[CO_TRAINED], "pedestrian": cast.populations[LEARNED]}
    rows = evaluate(cast.street, policies, Drawn(cast.street, cast.seed, episodes))
    found, reached = rows[ENCOUNTERS], rows[OUTCOMES].goal
    fit = [i for i in range(len(found.type)) if found.type[i] == JAYWALK and reached[found.episode[i]]]
    if not fit:
        return DrawnEpisode(0, 0, 0)
    best = min(fit, key=lambda i: (found.min_gap[i] == 0, found.min_gap[i]))
    return DrawnEpisode(int(found.scenario[best]), 0, 0, int(found.start[best]))

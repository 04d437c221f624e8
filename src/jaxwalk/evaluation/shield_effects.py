"""Compare a driver with itself behind a shield in the same scenarios: contacts avoided and caused, time and way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jaxwalk.evaluation.comparison import check_same_scenarios
from jaxwalk.metrics import OUTCOMES, Estimate, Rows, mcnemar
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.metrics.interventions_by_shield import SHIELD_INTERVENTIONS
from jaxwalk.metrics.statistics import mean_of
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.wording import counted


@dataclass(frozen=True)
class ShieldEffect:
    """What a shield changes in the same scenarios. Contacts are those of the moving car, by the world's rule."""

    driver: str
    """Name of the bare driver."""
    shield: str
    pedestrians: str
    jaywalk_multiplier: float
    scenarios: int
    both: int
    """Scenarios with a contact with and without the shield."""
    avoided: int
    """Scenarios with a contact of the bare driver only."""
    caused: int
    """Scenarios with a contact of the shielded driver only."""
    p: float
    """Exact McNemar p-value of the two, two-sided."""
    time_added: Estimate
    """Mean of how much later the shielded driver arrives, of scenarios in which both do [s]; the count is of those."""
    metres_lost: Estimate
    """Mean of how much further the bare driver drives [m]; negative where its contacts end episodes early."""
    in_words: str


def shield_effect(
    names: tuple[str, str, str], multiplier: float, bare: Rows, behind: Rows, contact: ContactRule
) -> ShieldEffect:
    """Return what a shield changes.

    Args:
        names: of the bare driver, the shield and the population.
        multiplier: the jaywalk multiplier.
        bare: rows of the bare driver.
        behind: rows of the shielded driver in the same scenarios.
        contact: the rule by which a contact counts.

    Raises:
        ValueError: the scenarios differ, or are in another order.
    """
    check_same_scenarios(bare, behind)
    driver, shield, people = names
    before, after = (touched_while_moving(rows, contact) for rows in (bare, behind))
    old, new = bare[OUTCOMES], behind[OUTCOMES]
    arrive = old.goal & new.goal
    time_added = mean_of((new.steps - old.steps)[arrive] * bare.dt)
    avoided, caused = int((before & ~after).sum()), int((after & ~before).sum())
    work = behind[SHIELD_INTERVENTIONS]
    each = work.interventions.sum() / max(new.driven.sum() / 1000, 1e-9)
    later = "" if time_added.value is None else f", and {time_added.value:+.1f} s where both arrive"
    words = (
        f"{driver}+{shield} among {people}: {counted(avoided, 'contact')} of the moving car avoided and {caused:,} "
        f"caused in {counted(bare.episodes, 'scenario')}; {each:.1f} interventions per km{later}."
    )
    return ShieldEffect(
        driver=driver,
        shield=shield,
        pedestrians=people,
        jaywalk_multiplier=multiplier,
        scenarios=bare.episodes,
        both=int((before & after).sum()),
        avoided=avoided,
        caused=caused,
        p=mcnemar(before, after),
        time_added=time_added,
        metres_lost=mean_of(old.driven.astype(np.float64) - new.driven),
        in_words=words,
    )


def shield_effects(
    played: Mapping[tuple[str, str], Rows], multiplier: float, contact: ContactRule
) -> tuple[ShieldEffect, ...]:
    """Return what each shield changes whose driver was evaluated without it too.

    ``played``: rows by names of driver and population, on one street; the rest is as in `shield_effect`.
    """
    found = []
    for (name, people), behind in played.items():
        driver, shield = unshielded("driver", name)
        if shield is not None and (driver, people) in played:
            found.append(shield_effect((driver, shield, people), multiplier, played[driver, people], behind, contact))
    return tuple(found)

"""Compare a driver with itself behind a shield in the same scenarios: contacts, how bad they are, time and way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.comparison import PairedRows, joint_counts
from jaxwalk.metrics import OUTCOMES, Estimate, Rows
from jaxwalk.metrics.contacts import MEASURED_CONTACTS, touched_while_moving, while_moving
from jaxwalk.metrics.expected_injuries import PER, expected_injuries
from jaxwalk.metrics.footprint import FRONT
from jaxwalk.metrics.interventions_by_shield import SHIELD_INTERVENTIONS
from jaxwalk.metrics.paired_tests import mcnemar_of_counts
from jaxwalk.metrics.statistics import mean_of
from jaxwalk.metrics.values import Values
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.wording import counted


@dataclass(frozen=True)
class MovingContacts:
    """The contacts of the moving car in all scenarios, by the world's rule."""

    contacts: int
    front: int
    """Those with the car's front; the others are with its sides and its rear."""
    car_speed: Estimate
    """Mean speed of the car [m/s]; the count is of contacts."""
    injuries: float
    """Serious injuries or deaths to be expected in 1,000 scenarios (`expected_injuries`)."""
    front_injuries: float
    """Those of contacts with the front alone."""


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
    bare: MovingContacts
    """Contacts without the shield."""
    shielded: MovingContacts
    """Contacts with it."""
    injuries_added: Estimate
    """Mean of how many more serious injuries are to be expected in 1,000 scenarios with the shield; negative: fewer."""
    front_injuries_added: Estimate
    """The same for contacts with the front alone."""
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
    pairs = PairedRows(bare, behind)
    driver, shield, people = names
    both, avoided, caused = pairs.total(
        lambda old, new: joint_counts(touched_while_moving(old, contact), touched_while_moving(new, contact))
    ).tolist()
    time_added = mean_of(pairs.values(_time_added))
    driven = behind.values(lambda chunk: chunk[OUTCOMES].driven).sum()
    each = behind.total(lambda chunk: chunk[SHIELD_INTERVENTIONS].interventions.sum()) / max(driven / 1000, 1e-9)
    later = "" if time_added.value is None else f", and {time_added.value:+.1f} s where both arrive"
    bare_contacts, shielded_contacts = (_moving_contacts(rows, contact) for rows in (bare, behind))
    added, front_added = (_injuries_added(pairs, contact, front_only=front) for front in (False, True))
    words = (
        f"{driver}+{shield} among {people}: {counted(avoided, 'contact')} of the moving car avoided and {caused:,} "
        f"caused in {counted(bare.episodes, 'scenario')}; {_harm(bare_contacts, shielded_contacts, added)}; "
        f"{each:.1f} interventions per km{later}."
    )
    return ShieldEffect(
        driver=driver,
        shield=shield,
        pedestrians=people,
        jaywalk_multiplier=multiplier,
        scenarios=bare.episodes,
        both=both,
        avoided=avoided,
        caused=caused,
        p=mcnemar_of_counts(avoided, caused),
        bare=bare_contacts,
        shielded=shielded_contacts,
        injuries_added=added,
        front_injuries_added=front_added,
        time_added=time_added,
        metres_lost=mean_of(pairs.values(_metres_lost)),
        in_words=words,
    )


def _time_added(bare: Rows, behind: Rows) -> Float[np.ndarray, "scenario"]:
    """Return how much later the shielded driver arrives where both do [s]."""
    old, new = bare[OUTCOMES], behind[OUTCOMES]
    return (new.steps - old.steps)[old.goal & new.goal] * bare.dt


def _metres_lost(bare: Rows, behind: Rows) -> Float[np.ndarray, "scenario"]:
    """Return how much further the bare driver drives [m]."""
    return bare[OUTCOMES].driven.astype(np.float64) - behind[OUTCOMES].driven


def _harm(bare: MovingContacts, shielded: MovingContacts, added: Estimate) -> str:
    """Return in words how bad the contacts are; the difference of injuries has its interval, if there is one."""
    difference = "" if added.low is None else f" ({added.value:+.1f} [{added.low:.1f}, {added.high:.1f}])"
    return (
        f"bare {bare.front:,} of {bare.contacts:,} with its front, shielded {shielded.front:,} of "
        f"{shielded.contacts:,}; serious injuries to be expected in {PER:,} scenarios: {bare.injuries:.1f} bare, "
        f"{shielded.injuries:.1f} shielded{difference}"
    )


def _injuries_added(pairs: PairedRows, contact: ContactRule, *, front_only: bool) -> Estimate:
    each = partial(expected_injuries, contact=contact, front_only=front_only)
    return mean_of(pairs.values(lambda bare, behind: PER * (each(behind) - each(bare))))


def _moving_contacts(rows: Rows, contact: ContactRule) -> MovingContacts:
    def column(name: str) -> Values:
        return rows.values(lambda chunk: getattr(chunk[MEASURED_CONTACTS], name)[while_moving(chunk, contact)])

    def injuries(*, front_only: bool) -> float:
        each = rows.values(partial(expected_injuries, contact=contact, front_only=front_only))
        return PER * each.sum() / rows.episodes

    part, speed = column("part"), column("car_speed")
    return MovingContacts(
        contacts=part.count,
        front=part.each(lambda piece: piece[piece == FRONT]).count,
        car_speed=mean_of(speed, within=(0.0, math.inf)),
        injuries=injuries(front_only=False),
        front_injuries=injuries(front_only=True),
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

"""How many people are to be expected to be seriously injured, from the speeds of the car in its contacts."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from jaxwalk.metrics.contacts import MEASURED_CONTACTS, while_moving
from jaxwalk.metrics.footprint import FRONT
from jaxwalk.metrics.injury import monfort_mueller_mais3
from jaxwalk.metrics.metric import Rows
from jaxwalk.sim.sim_config import ContactRule

PER = 1000
"""Injuries are given for this many scenarios."""


def expected_injuries(rows: Rows, contact: ContactRule, *, front_only: bool = False) -> Float[np.ndarray, "episode"]:
    """Return the serious injuries or deaths (MAIS 3+) to be expected in each episode: its contacts' risks, added up.

    The risk is that of a contact with the front of a car at this speed (`monfort_mueller_mais3`). Contacts with the
    sides and the rear of the moving car count as if they were with its front, or with ``front_only`` not at all.
    """
    table, mine = rows[MEASURED_CONTACTS], while_moving(rows, contact)
    if front_only:
        mine = mine & (table.part == FRONT)
    found = np.zeros(rows.episodes)
    np.add.at(found, table.episode[mine], monfort_mueller_mais3(table.car_speed[mine]))
    return found

"""Find every contact by both rules, the paper's disc and the car's footprint, whichever of them ends episodes.

A pedestrian's first contact by each rule counts, and no later one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, get_args

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.counts import proportion
from jaxwalk.metrics.crossings import crossing_type
from jaxwalk.metrics.footprint import FRONT, REAR, SIDE, in_car_frame, near_car, touched_part
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.outcomes import CONTACTS, SIDEWALK
from jaxwalk.metrics.statistics import Estimate, Rate, mean_of
from jaxwalk.sim import events
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.sim_config import ContactRule, SimConfig
from jaxwalk.sim.trajectory import Trajectory

RULES: tuple[ContactRule, ...] = get_args(ContactRule)
"""What counts as a contact. An axis named ``rule`` has them in this order."""
CELLS = 10
"""Hit points are counted in this many equal parts of the car's width."""


@dataclass(frozen=True)
class Contacts:
    """One row per pedestrian and rule, ordered by episode, pedestrian and rule."""

    episode: Int[np.ndarray, "contact"]
    """Row of the episode."""
    ped: Int[np.ndarray, "contact"]
    rule: Int[np.ndarray, "contact"]
    """Index of `RULES`."""
    frame: Int[np.ndarray, "contact"]
    """The first frame in contact."""
    type: Int[np.ndarray, "contact"]
    """CROSSWALK, JAYWALK or SIDEWALK: what the pedestrian was doing."""
    car_speed: Float[np.ndarray, "contact"]
    """Speed of the car in that frame [m/s]."""
    relative_speed: Float[np.ndarray, "contact"]
    """Speed of the pedestrian relative to the car [m/s]."""
    moving: Bool[np.ndarray, "contact"]
    """Whether the car was moving; else somebody walked into a standing car."""
    part: Int[np.ndarray, "contact"]
    """FRONT, SIDE or REAR of the car (`jaxwalk.metrics.footprint`)."""
    hit_point: Float[np.ndarray, "contact"]
    """Place on the car's front or rear in per cent of its width, 0 at the right edge; NaN for its sides."""


def find_contacts(trajectory: Trajectory, config: SimConfig) -> Contacts:
    """Find the contacts of a trajectory; ``config`` has the sizes of the disc, the car and the body."""
    frame, episode, ped = near_car(trajectory, config)
    place = in_car_frame(trajectory, frame, episode, ped)
    rule, row = [], []
    for index, name in enumerate(RULES):
        touched = np.flatnonzero(events.touching(replace(config, contact=name), *place, 1.0, 0.0))
        _, first = np.unique(np.stack([episode[touched], ped[touched]]), axis=1, return_index=True)
        row.append(touched[first])
        rule.append(np.full(len(first), index))
    rule, row = np.concatenate(rule), np.concatenate(row)
    order = np.lexsort((rule, ped[row], episode[row]))
    rule, row = rule[order], row[order]
    frame, episode, ped = frame[row], episode[row], ped[row]
    speed = trajectory.car_speed[frame, episode]
    vx, vy = (getattr(trajectory, f"ped_v{x}")[frame, episode, ped] for x in "xy")
    ahead, aside = to_frame(vx, vy, trajectory.car_cos[frame, episode], trajectory.car_sin[frame, episode])
    part, hit_point = _part(trajectory, frame, episode, ped, config)
    walking = crossing_type(trajectory.crossing[frame, episode, ped], trajectory.on_crosswalk[frame, episode, ped])
    return Contacts(
        episode=episode.astype(np.int32),
        ped=ped.astype(np.int16),
        rule=rule.astype(np.int8),
        frame=frame.astype(np.int32),
        type=np.where(trajectory.on_roadway[frame, episode, ped], walking, SIDEWALK).astype(np.int8),
        car_speed=speed.astype(np.float32),
        relative_speed=events.distance(ahead - speed, aside).astype(np.float32),
        moving=speed >= config.moving_speed,
        part=part.astype(np.int8),
        hit_point=hit_point.astype(np.float32),
    )


def _part(trajectory, frame, episode, ped, config: SimConfig) -> tuple[np.ndarray, np.ndarray]:
    """Return which part of the car was touched, and where, as `touched_part` does."""
    after, before = (in_car_frame(trajectory, at, episode, ped) for at in (frame, np.maximum(frame - 1, 0)))
    seen = np.isfinite(before[0])  # a recording may begin with the contact
    ahead, left = (np.where(seen, old, new) for old, new in zip(before, after, strict=True))
    return touched_part(*after, ahead, left, config)


def while_moving(rows: Rows, rule: ContactRule = "footprint") -> Bool[np.ndarray, "contact"]:
    """Return which rows of `Contacts` are of the moving car, by this rule."""
    table = rows[MEASURED_CONTACTS]
    return table.moving & (table.rule == RULES.index(rule))


def touched_while_moving(rows: Rows, rule: ContactRule = "footprint") -> Bool[np.ndarray, "episode"]:
    """Return in which episodes the moving car touched somebody, by this rule."""
    found = np.zeros(rows.episodes, bool)
    found[rows[MEASURED_CONTACTS].episode[while_moving(rows, rule)]] = True
    return found


@dataclass(frozen=True)
class ContactsByRule:
    """The contacts by one rule."""

    episodes: Rate
    """Share of the episodes with a contact."""
    moving: Rate
    """Share of the episodes with a contact while the car was moving."""
    contacts: int
    """All contacts, at most one for each pedestrian of an episode."""
    standing: int
    """Those in which somebody walked into a standing car."""
    crosswalk: int
    """Contacts with people on a crosswalk ..."""
    jaywalk: int
    sidewalk: int
    front: int
    """Contacts of the moving car with its front ..."""
    side: int
    rear: int
    hit_points: tuple[int, ...]
    """Contacts of the moving car's front in each tenth of its width, from its right edge."""
    car_speed: Estimate
    """Mean speed of the moving car [m/s]."""
    relative_speed: Estimate
    """Mean speed of the pedestrian relative to the moving car [m/s]."""


@dataclass(frozen=True)
class BothRules:
    """Contacts by both rules. The world says which of them ended the episodes."""

    disc: ContactsByRule
    """The centres closer than the collision distance (the paper's criterion)."""
    footprint: ContactsByRule
    """The body overlapped the car's rectangle."""


def summarise_contacts(rows: Rows, sums: Sums) -> BothRules:
    """Return the contacts by both rules."""
    return BothRules(*(_summarise_rule(rows, rule) for rule in range(len(RULES))))


def _summarise_rule(rows: Rows, rule: int) -> ContactsByRule:
    found = rows.total(partial(_counts, rule))
    hit_points, (episodes, moving) = found.pop("hit_points"), found.pop("episodes")

    def mean(name: str) -> Estimate:
        speeds = rows.values(lambda chunk: getattr(chunk[MEASURED_CONTACTS], name)[while_moving(chunk, RULES[rule])])
        return mean_of(speeds, within=(0.0, np.inf))

    return ContactsByRule(
        episodes=proportion(episodes, rows.episodes),
        moving=proportion(moving, rows.episodes),
        hit_points=tuple(hit_points.tolist()),
        car_speed=mean("car_speed"),
        relative_speed=mean("relative_speed"),
        **{name: int(count) for name, count in found.items()},
    )


def _counts(rule: int, rows: Rows) -> dict[str, Any]:
    """Return the counts of `ContactsByRule`; ``episodes`` are those with a contact, and with one of the moving car."""
    table = rows[MEASURED_CONTACTS]
    mine = table.rule == rule
    moving = mine & table.moving
    front = moving & (table.part == FRONT)
    cell = np.minimum(table.hit_point[front] / 100 * CELLS, CELLS - 1).astype(np.int64)
    return {
        "episodes": np.array([len(np.unique(table.episode[which])) for which in (mine, moving)]),
        "contacts": mine.sum(),
        "standing": (mine & ~table.moving).sum(),
        **{x.name.lower(): (mine & (table.type == x)).sum() for x in CONTACTS},
        **{name: (moving & (table.part == x)).sum() for name, x in PARTS.items()},
        "hit_points": np.bincount(cell, minlength=CELLS),
    }


PARTS = {"front": FRONT, "side": SIDE, "rear": REAR}
MEASURED_CONTACTS = Metric(
    name="contacts",
    measure=lambda recording: find_contacts(recording.trajectory, recording.config),
    summarise=summarise_contacts,
    headline=True,
)

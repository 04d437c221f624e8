"""What one page of `jaxwalk live` plays: a scenario that is opened, stepped through, and saved. It knows no network."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np

from jaxwalk.evaluation import named, with_jaywalk_multiplier
from jaxwalk.evaluation.hosted import ask
from jaxwalk.evaluation.playing import Underway, answered, begin, check_actions, host_driver, play_block
from jaxwalk.interfaces import Policy
from jaxwalk.live.by_hand import ByHand
from jaxwalk.live.live_choice import LiveChoice, LiveError
from jaxwalk.live.live_frames import first_record, moment_record
from jaxwalk.live.live_offer import Offer
from jaxwalk.policies import RouteFollower
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.runs.lock import held
from jaxwalk.scenarios import Archived, Drawn
from jaxwalk.scenarios.archive_file import write_archive
from jaxwalk.scenarios.archived import keys_of, scenarios_at
from jaxwalk.sim.environment import Street
from jaxwalk.sim.recording import Frame
from jaxwalk.sim.sim_config import rules_of
from jaxwalk.sim.world import as_written

Load = Callable[[Street, str, str], Policy]
"""A function of street, role and name that returns the policy of that name."""
NOBODY_DRIVES = (0.0, 0.0, float("nan"))
"""The hand of a page where the chosen driver drives."""
PATIENCE = 10.0
"""How long a page waits until others have saved [s]."""


@lru_cache(maxsize=8)
def street_of(name: str, world: str, places: int) -> Street:
    """Return the street of a map in a world, with places for this many people. It is kept.

    Raise MapError for a wrong map, and LiveError for a street that the world's car doesn't fit on.
    """
    rules = replace(rules_of(world, (name,)), pedestrians=places)
    try:
        return Street.create((name,), rules)
    except ValueError as error:
        if type(error).__module__.startswith("jaxwalk"):
            raise
        raise LiveError(f"{name} in the world {world}: {error}; choose another one") from error


class LiveSession:
    """A scenario in progress. `open` comes first; it is a function of the choice alone, whatever was played before."""

    def __init__(self, offer: Offer, folder: Path, load: Load) -> None:
        """Play what is offered, save into ``folder``, and get policies from ``load``."""
        self.offer, self._folder, self._load = offer, folder, load
        self.choice = offer.start
        self.hand: tuple[float, float, float] = NOBODY_DRIVES
        self._source: Archived | None = None

    @property
    def ended(self) -> bool:
        """Whether there is nothing more to play."""
        return self._source is None or bool(self._game.ended[0])

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return self._street.world.rules.dt

    def open(self, choice: LiveChoice) -> dict[str, Any]:
        """Begin a scenario, and return what a page needs to draw it. What isn't compiled yet is compiled here.

        Raise LiveError, or another ValueError of jaxwalk, for what can't be played: then the scenario before goes on.
        """
        self.offer.check(choice)
        street, source = self._dialled(choice)
        driver, people = (self._load(street, *one) for one in (("driver", choice.driver),
                                                               ("pedestrian", choice.pedestrians)))  # fmt: skip
        follower = with_limits(RouteFollower(), street.config)
        policies = {"driver": ByHand(driver, follower, _on_device(NOBODY_DRIVES)), "pedestrian": people}
        scenarios = scenarios_at(street, source.points, ~source.present.T)
        setup, game, first = begin(street, policies, scenarios, keys_of(source.seed, source.keys))
        play_block(setup, game, 1)  # compiles it now, and not while somebody plays
        if host := host_driver(policies):
            with host.lock:
                host.init((), (1,))
        self.choice, self._street, self._source = _as_played(choice, street, source), street, source
        self._policies, self._setup, self._game = policies, setup, game
        frame = _on_host(first)
        self._known = frame.get("perceived")
        hides = street.world.rules.perception and street.world.slots > 0
        shown = {"choice": asdict(self.choice), "hides": hides, "most": int(self._there(choice).sum())}
        return {**shown, **first_record(street, scenarios), "frame": moment_record(frame, None)}

    def step(self) -> dict[str, Any]:
        """Make one step, and return its frame, with the ending if it was the last one. There must be one to make.

        Raise DriverError or ActionError if a policy fails.
        """
        policies = eqx.tree_at(lambda all: all["driver"].hand, self._policies, _on_device(self.hand))
        numbers = np.array([self.choice.number])
        if host := host_driver(policies):
            seen = self._street.observe(self._setup.scenarios, self._game.state, host.view)
            now = int(self._game.state.step[0])
            with host.lock:
                answer = ask(host, seen, playing=np.array([True]), numbers=numbers, step=now)
            policies = answered(policies, answer)
        self._game, frames = play_block(replace(self._setup, policies=policies), self._game, 1)
        frame = {name: column[0] for name, column in _on_host(frames).items()}
        with named({"driver": self.choice.driver, "pedestrian": self.choice.pedestrians}):
            check_actions(self._street, self._game, numbers)
        shown = moment_record(frame, self._known)
        self._known = frame.get("perceived")
        return {**shown, **_ending(self._game)} if self.ended else shown

    def save(self) -> Path:
        """Write the scenario, with its dials, as a file that `jaxwalk play` and `evaluate` take; return its path."""
        if self._source is None:
            raise LiveError("there is no scenario to save yet; open one")
        choice = self.choice
        about = {"kind": "live", "driver": choice.driver, "pedestrians": choice.pedestrians}
        self._folder.mkdir(parents=True, exist_ok=True)
        origin = "kept" if self.offer.kept is not None else f"seed-{choice.seed}"
        with held(self._folder, seconds=PATIENCE):  # another page may save under the same name
            path = _new_name(self._folder, f"{Path(choice.street).stem}-{origin}-{choice.number}")
            write_archive(path, self._source, about)
        return path

    def _dialled(self, choice: LiveChoice) -> tuple[Street, Archived]:
        """Return the street with its dials turned, and the scenario on it. Dials are arrays: nothing is compiled."""
        kept = self.offer.kept
        street = kept.street if kept is not None else street_of(choice.street, choice.world, choice.places)
        if choice.jaywalk_multiplier is not None:
            street = with_jaywalk_multiplier(street, choice.jaywalk_multiplier)
        street = _with_rule(street, "max_speed", choice.max_speed)
        street = _with_rule(street, "parked", choice.parked if street.world.slots else None)
        row = np.array([choice.number])
        if kept is not None:
            points, seed, keys = kept.points[row], kept.seed, kept.keys[row]
        else:
            points, seed, keys = Drawn(street, choice.seed).points(row), choice.seed, row
        present = self._there(choice)
        if choice.people is not None:  # who is left out of a file stays so, and doesn't count
            present = present & (np.cumsum(present) <= choice.people)
        return street, Archived(street, points, present, seed, keys)

    def _there(self, choice: LiveChoice) -> np.ndarray:
        """Return who can be there, ``(1, ped)``: in a file of scenarios all but those that it leaves out."""
        kept = self.offer.kept
        return np.ones((1, choice.places), bool) if kept is None else kept.present[np.array([choice.number])]


def _with_rule(street: Street, name: str, value: float | None) -> Street:
    """Return the street with another number for one of its rules that are arrays; None leaves it."""
    if value is None:
        return street
    return eqx.tree_at(lambda street: getattr(street.world.rules, name), street, _on_device(value))


def _on_host(frame: Frame) -> dict[str, np.ndarray]:
    return {name: np.asarray(column) for name, column in frame.items()}


def _on_device(numbers: Any) -> jax.Array:
    return jax.device_put(np.asarray(numbers, np.float32))


def _as_played(choice: LiveChoice, street: Street, source: Archived) -> LiveChoice:
    """Return the choice with a number for each dial."""
    rules = street.world.rules
    numbers = {name: as_written(getattr(rules, name)) for name in ("jaywalk_multiplier", "max_speed")}
    parked = as_written(rules.parked) if street.world.slots else None
    return replace(choice, people=int(source.present.sum()), parked=parked, **numbers)


def _ending(game: Underway) -> dict[str, Any]:
    """Return how an episode ended, and who was hit."""
    hit, arrived = bool(game.collision[0]), bool(game.goal[0])
    touched = np.flatnonzero(np.asarray(game.touched)[:, 0]).tolist() if hit else []
    return {"ending": "collision" if hit else "goal" if arrived else "timeout", "touched": touched}


def _new_name(folder: Path, name: str) -> Path:
    """Return the path of a file that isn't there yet."""
    number, path = 1, folder / f"{name}.safetensors"
    while path.exists():
        number += 1
        path = folder / f"{name}-{number}.safetensors"
    return path

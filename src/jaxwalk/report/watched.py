"""What a page's reader can watch: the worst collisions and the nearest misses."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from jaxwalk.viewer.drawn_map import DrawnMap


@dataclass(frozen=True)
class WatchedIncident:
    """A collision or a near miss in one of the gallery's episodes."""

    episode: int
    """Index among the episodes."""
    kind: str
    """``collision`` or ``near miss``."""
    contact: str
    """What the pedestrian was doing: ``crosswalk``, ``jaywalk`` or ``sidewalk``."""
    moving: bool
    """Whether the car was moving."""
    ped: int
    t: float
    """When it happened, from the episode's start [s]."""
    car: str
    """What the car was doing, in words."""
    side: str
    """Where the pedestrian came from, in words."""
    avoidable: str | None
    """Who could have avoided the collision (`jaxwalk.evaluation.counterfactual.LABELS`); None for a near miss."""
    speed: float | None
    """Impact speed [m/s]."""
    risk: float | None
    """Risk of a serious injury."""
    ttc: float | None
    """Smallest time to collision [s]."""
    nearest: float | None
    """Smallest gap between car and body [m]."""


@dataclass(frozen=True)
class WatchedEpisode:
    """An episode as the page's player reads it (`jaxwalk.viewer.replay.entries`)."""

    driver: str
    pedestrians: str
    multiplier: float
    scenario: int
    ending: str
    steps: int
    map: int
    """Index among the maps."""
    record: str
    """All frames, packed."""


@dataclass(frozen=True)
class Gallery:
    """The incidents of an evaluation, and the episodes in which they happened, under every driver."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    dt: float
    """Duration of a step [s]."""
    maps: tuple[DrawnMap, ...]
    """The maps that the player draws."""
    episodes: tuple[WatchedEpisode, ...]
    lead: float
    """Playback of an incident starts this long before it [s]."""
    most: int
    """Largest number of incidents of each kind, for each driver and population."""
    scenarios: int
    """Number of scenarios in which incidents were searched, from the first on."""
    incidents: tuple[WatchedIncident, ...]

    def __post_init__(self) -> None:
        """Raise ValueError for an incident without an episode, or an episode without a map."""
        for incident in self.incidents:
            if not 0 <= incident.episode < len(self.episodes):
                raise ValueError(f"an incident's episode {incident.episode} is not one of {len(self.episodes)}")
        for episode in self.episodes:
            if not 0 <= episode.map < len(self.maps):
                raise ValueError(f"an episode's map {episode.map} is not one of {len(self.maps)}")

    @property
    def collisions(self) -> set[str]:
        """Return the drivers and populations with a collision to watch, as in ``co-trained among learned``."""
        hits = (self.episodes[one.episode] for one in self.incidents if one.kind == "collision")
        return {f"{episode.driver} among {episode.pedestrians}" for episode in hits}

    def as_dict(self) -> dict[str, Any]:
        """Return what the page's script reads."""
        return asdict(self)

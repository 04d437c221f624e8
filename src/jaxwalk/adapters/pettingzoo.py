"""PettingZoo: the car and the pedestrians as agents of a `pettingzoo.ParallelEnv`."""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np

try:
    from gymnasium.spaces import Box, Discrete, Space
    from pettingzoo import ParallelEnv
except ImportError as error:
    raise ImportError("jaxwalk.adapters.pettingzoo needs PettingZoo: pip install 'jaxwalk[envs]'") from error

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Key

from jaxwalk.adapters.camera import Camera
from jaxwalk.adapters.game import EVENTS, Game, WorldOptions, begin, keys_of, play, renew, rewards_of
from jaxwalk.adapters.players import AdapterError, Weights
from jaxwalk.interfaces import Outcome, Roles, View
from jaxwalk.rollout import EVALUATION, TRAINING, Stream
from jaxwalk.sim.observation import bounds
from jaxwalk.sim.sim_config import SimConfig

DRIVER, PEDESTRIAN = "driver", "pedestrian_"
"""The car's name, and the prefix of the pedestrians' names."""


class StreetParallelEnv(ParallelEnv[str, np.ndarray, Any]):
    """One car, ``driver``, and pedestrians ``pedestrian_0`` and so on. An episode ends for all agents at once.

    Agents in a collision have ``terminated``, and so has a driver who arrived; for all others the end is ``truncated``.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (as PettingZoo declares it)
        "name": "jaxwalk_street_v0",
        "render_modes": ["rgb_array"],
        "render_fps": round(1 / SimConfig.dt),
        "is_parallelizable": True,
    }

    def __init__(
        self,
        *,
        driver_observation: str = "route",
        pedestrian_observation: str = "kerb",
        driver_reward: Weights = "fast",
        pedestrian_reward: Weights = "fast",
        render_mode: str | None = None,
        **world: Unpack[WorldOptions],
    ) -> None:
        """Create a street; options are those of `jaxwalk.adapters.gymnasium.StreetEnv`, for each role.

        Raise ValueError for an impossible option; the message names it.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise AdapterError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        self.game = Game.create(
            driver=None, pedestrians=None, driver_reward=driver_reward, pedestrian_reward=pedestrian_reward, **world
        )
        self.people = self.game.street.world.rules.pedestrians
        self.possible_agents = [DRIVER, *(f"{PEDESTRIAN}{i}" for i in range(self.people))]
        self.agents: list[str] = []
        street = self.game.street
        observations = {"driver": driver_observation, "pedestrian": pedestrian_observation}
        self.views = {role: street.view(role, name) for role, name in observations.items()}
        self._observation_spaces: dict[str, Space] = {
            name: _space(self.game, "driver", driver_observation)
            if name == DRIVER
            else _space(self.game, "pedestrian", pedestrian_observation)
            for name in self.possible_agents
        }
        self._action_spaces: dict[str, Space] = {
            name: Box(-1.0, 1.0, (2,), np.float32) if name == DRIVER else Discrete(2) for name in self.possible_agents
        }
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1 / self.game.street.world.rules.dt)}
        self.camera = Camera(self.game.street) if render_mode else None
        self._stream: Stream | None = None
        self._seed: int | None = None

    def observation_space(self, agent: str) -> Space:
        """Return the observation space of an agent."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> Space:
        """Return the action space: acceleration and steering as shares of their limits, or wait (0) and go (1)."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begin an episode: a seed's first one, or the next; ``options={"scenario": n}`` as in an evaluation."""
        if seed is not None or self._seed is None or self._stream is None or "scenario" in (options or {}):
            fresh = int(np.random.default_rng().integers(2**32)) if self._seed is None else self._seed
            self._seed = fresh if seed is None else seed
            domain = EVALUATION if "scenario" in (options or {}) else TRAINING
            keys = keys_of(self._seed, domain, first=(options or {}).get("scenario", 0))
            self._stream, seen = _begin(self.game, self.views, keys)
        else:
            self._stream, seen = _next(self.game, self.views, self._stream)
        self.agents = list(self.possible_agents)
        if self.camera is not None:
            self.camera.begin(self._stream)
        return self._by_name(seen), {name: {} for name in self.agents}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Make one step of all agents."""
        if self._stream is None or not self.agents:
            raise AdapterError("the episode is over: call reset before the next step")
        together = self._together(actions)
        stream, *brought = _step(self.game, self.views, self._stream, together)
        self._stream, (seen, earned, outcome) = stream, jax.device_get(brought)
        if self.camera is not None:
            self.camera.add(stream, np.stack([getattr(outcome.events, name) for name in EVENTS]))
        rewards, terminated, truncated = (
            {name: x.item() for name, x in self._by_name(each).items()}
            for each in (earned, outcome.terminated, outcome.truncated)
        )
        infos = self._infos(outcome)
        if terminated[DRIVER] or truncated[DRIVER]:
            self.agents = []
        return self._by_name(seen), rewards, terminated, truncated, infos

    def render(self) -> np.ndarray | None:
        """Return a picture of the street now, with ``render_mode="rgb_array"``."""
        return None if self.camera is None else self.camera.picture()

    def _by_name(self, each: Roles[Any]) -> dict[str, np.ndarray]:
        """Return each agent's part of arrays ``(..., env)`` and ``(..., ped, env)`` of one environment."""
        people = {f"{PEDESTRIAN}{i}": each["pedestrian"][..., i, 0] for i in range(self.people)}
        return {name: np.array(x) for name, x in {DRIVER: each["driver"][..., 0], **people}.items()}

    def _together(self, actions: dict[str, Any]) -> Roles[np.ndarray]:
        """Return all agents' actions as arrays of one environment."""
        missing = [name for name in self.agents if name not in actions]
        if missing:
            raise AdapterError(f"no action for {', '.join(missing)}: every agent acts at every step")
        wrong = [name for name in self.agents if not np.isfinite(actions[name]).all()]
        if wrong:
            raise AdapterError(f"the action of {wrong[0]} has a number that is not finite")
        drive = np.asarray(actions[DRIVER], np.float32)
        go = np.array([actions[name] for name in self.possible_agents[1:]], np.int32)
        if drive.shape != (2,) or go.shape != (self.people,):
            raise AdapterError(f"the driver gives 2 numbers, a pedestrian one, not {drive.shape} and {go.shape[1:]}")
        given = {"driver": drive[:, None], "pedestrian": go[:, None]}
        space = self.game.street.roles["pedestrian"]
        if not space.contains(given["pedestrian"]).all():
            raise AdapterError(f"a pedestrian's action is not {space.action}")
        return given

    def _infos(self, outcome: Outcome) -> dict[str, dict[str, Any]]:
        """Return how the episode ended, if it did, and the terms of each agent's reward."""
        events = {name: bool(getattr(outcome.events, name)[0]) for name in EVENTS}
        infos = {name: {**events, "rewards": {}} for name in self.possible_agents}
        for term, of_driver in outcome.rewards["driver"].items():
            infos[DRIVER]["rewards"][term] = float(of_driver[0])
        for term, of_people in outcome.rewards["pedestrian"].items():
            for name, x in zip(self.possible_agents[1:], of_people[:, 0].tolist(), strict=True):
                infos[name]["rewards"][term] = x
        return infos


def _space(game: Game, role: str, observation: str) -> Box:
    street = game.street
    return Box(*bounds(street.world, role, observation))


@eqx.filter_jit
def _begin(game: Game, views: Roles[View], keys: Key[Array, "env"]) -> tuple[Stream, Roles[Array]]:
    stream = begin(game, keys)
    return stream, _observe(game, views, stream)


@eqx.filter_jit
def _next(game: Game, views: Roles[View], stream: Stream) -> tuple[Stream, Roles[Array]]:
    stream = renew(game, stream, jnp.ones(stream.shown.shape, bool))
    return stream, _observe(game, views, stream)


@eqx.filter_jit
def _step(
    game: Game, views: Roles[View], stream: Stream, actions: Roles[Any]
) -> tuple[Stream, Roles[Array], Roles[Array], Outcome]:
    """Return the stream after a step, all observations, each agent's reward, and the outcome."""
    stream, step = play(game, stream, jax.tree.map(jnp.asarray, actions))
    return stream, _observe(game, views, stream), rewards_of(step.outcome), step.outcome


def _observe(game: Game, views: Roles[View], stream: Stream) -> Roles[Array]:
    return {role: game.street.observe(stream.scenario, stream.state, view) for role, view in views.items()}

"""Gymnasium: drive the car among a chosen population. Importing this registers ``jaxwalk/Street-v0``.

``gymnasium.make("jaxwalk/Street-v0", ...)`` and ``gymnasium.make_vec("jaxwalk/Street-v0", num_envs, ...)`` take the
options of `StreetEnv` and `StreetVectorEnv`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError as error:
    raise ImportError("jaxwalk.adapters.gymnasium needs Gymnasium: pip install 'jaxwalk[envs]'") from error

import jax
import jax.numpy as jnp

from jaxwalk.adapters.camera import Camera
from jaxwalk.adapters.game import EVENTS, SEEDS, Game, WorldOptions, keys_of
from jaxwalk.adapters.players import AdapterError, Weights
from jaxwalk.adapters.seat import NEVER, NEXT_STEP, SAME_STEP, Seat, Seen
from jaxwalk.interfaces import Policy
from jaxwalk.rollout import EVALUATION, TRAINING
from jaxwalk.sim.sim_config import SimConfig

ID = "jaxwalk/Street-v0"
_MODES = {AutoresetMode.NEXT_STEP: NEXT_STEP, AutoresetMode.SAME_STEP: SAME_STEP}


class StreetEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One car among pedestrians: a `gymnasium.Env`.

    ``reset(seed=s)`` begins the first episode of a seed; further calls of ``reset`` begin its next ones.
    ``reset(seed=s, options={"scenario": n})`` plays scenario n of ``jaxwalk evaluate --seed s``.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (as Gymnasium declares it)
        "render_modes": ["rgb_array"],
        "render_fps": round(1 / SimConfig.dt),
    }

    def __init__(
        self,
        *,
        observation: str = "route",
        pedestrians: str | Path | Policy = "always-go",
        reward: Weights = "fast",
        costs: Sequence[str] = ("contact",),
        render_mode: str | None = None,
        **world: Unpack[WorldOptions],
    ) -> None:
        """Create a street.

        Args:
            observation: the driver's observation set (``docs/adapters.md``).
            pedestrians: a rule or shipped policy by name, a policy file or a `Policy`.
            reward: name of the recipe that defines the car's reward, or weights of reward terms.
            costs: names of the costs whose sum is ``info["cost"]`` (`jaxwalk.sim.cost.DRIVER_COSTS`).
            render_mode: ``rgb_array`` or None.
            world: ``maps``, ``jaywalk_multiplier`` and ``config`` (`WorldOptions`).

        Raises:
            ValueError: an option is impossible; the message names it.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise AdapterError(f"render_mode must be None or 'rgb_array', not {render_mode!r}")
        game = _game(pedestrians, reward, costs, world)
        self.seat = Seat(game, 1, observation=observation, autoreset=NEVER)
        self.observation_space, self.action_space = _spaces(self.seat)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1 / game.street.world.rules.dt)}
        self.camera = Camera(game.street) if render_mode else None
        self._ended = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode."""
        begins = seed is not None or self._np_random is None or "scenario" in (options or {})
        super().reset(seed=seed)
        observation = self.seat.begin(_keys(self, seed, options, 1)) if begins else self.seat.next(np.ones(1, bool))
        self._ended = False
        if self.camera is not None:
            self.camera.begin(self.seat.stream)
        return observation[0], {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Make one step with acceleration and steering, as shares of their limits."""
        if self._ended:
            raise AdapterError("the episode is over: call reset before the next step")
        seen = self.seat.step(np.asarray(action)[None])
        self._ended = bool(seen.ended[0])
        if self.camera is not None:
            self.camera.add(self.seat.stream, seen.events)
        info: dict[str, Any] = dict(zip(EVENTS, seen.events[:, 0].tolist(), strict=True))
        info["rewards"] = dict(zip(self.seat.terms, seen.terms[:, 0].tolist(), strict=True))
        info["costs"] = dict(zip(self.seat.costs, seen.costs[:, 0].tolist(), strict=True))
        info["cost"] = float(seen.cost[0])
        ends = bool(seen.terminated[0]), bool(seen.truncated[0])
        return seen.observation[0], float(seen.reward[0]), *ends, info

    def render(self) -> np.ndarray | None:
        """Return a picture of the street now, with ``render_mode="rgb_array"``."""
        return None if self.camera is None else self.camera.picture()


class StreetVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Many streets in one compiled step: a `gymnasium.vector.VectorEnv` with automatic resets.

    With ``reset(seed=s)``, street i plays the episodes of the seed's i-th key, so no two seeds share a street
    (Gymnasium's own wrappers use seed s + i). With a list of seeds, each street equals a `StreetEnv` with its seed.
    With ``options={"scenario": n}``, street i begins with scenario n + i of ``jaxwalk evaluate --seed s``.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012 (as Gymnasium declares it)

    def __init__(
        self,
        num_envs: int = 1,
        *,
        observation: str = "route",
        pedestrians: str | Path | Policy = "always-go",
        reward: Weights = "fast",
        costs: Sequence[str] = ("contact",),
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **world: Unpack[WorldOptions],
    ) -> None:
        """Create ``num_envs`` streets; the other options are those of `StreetEnv`.

        ``autoreset_mode``: with NEXT_STEP, the step after an episode's last one ignores the action and begins the next
        episode. With SAME_STEP, the last step already returns the start of the next one (the info has ``final_obs``).
        """
        mode = AutoresetMode(autoreset_mode)
        if mode not in _MODES:
            raise AdapterError(f"autoreset_mode must be NextStep or SameStep, not {mode.value}")
        self.metadata = {**self.metadata, "autoreset_mode": mode}
        self.num_envs = num_envs
        game = _game(pedestrians, reward, costs, world)
        self.seat = Seat(game, num_envs, observation=observation, autoreset=_MODES[mode])
        self.single_observation_space, self.single_action_space = _spaces(self.seat)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode in every street."""
        begins = seed is not None or self._np_random is None or "scenario" in (options or {})
        super().reset(seed=seed[0] if isinstance(seed, list) else seed)
        if begins:
            return self.seat.begin(_keys(self, seed, options, self.num_envs)), {}
        return self.seat.next(np.ones(self.num_envs, bool)), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Make one step in every street."""
        seen = self.seat.step(actions)
        infos = _infos(self.seat, seen, seen.valid) if seen.final is None else _with_final(self.seat, seen)
        return seen.observation, seen.reward, seen.terminated, seen.truncated, infos


def _game(pedestrians: str | Path | Policy, reward: Weights, costs: Sequence[str], world: WorldOptions) -> Game:
    return Game.create(
        driver=None, pedestrians=pedestrians, driver_reward=reward, pedestrian_reward={},
        driver_costs=(costs,) if isinstance(costs, str) else costs, **world,
    )  # fmt: skip


def _spaces(seat: Seat) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
    """Return the observation space and the action space."""
    return gymnasium.spaces.Box(seat.low, seat.high), gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)


def _keys(env: Any, seed: int | list[int] | None, options: dict[str, Any] | None, count: int) -> jax.Array:
    """Return the environments' keys; without a seed, Gymnasium draws one."""
    if isinstance(seed, list):
        if len(seed) != count:
            raise AdapterError(f"{count} environments need as many seeds, not {len(seed)}")
        return jnp.concatenate([_keys(env, one, options, 1) for one in seed])
    chosen = env.np_random_seed % SEEDS if seed is None else seed
    domain = EVALUATION if "scenario" in (options or {}) else TRAINING
    return keys_of(int(chosen), domain, first=int((options or {}).get("scenario", 0)), count=count)


def _infos(seat: Seat, seen: Seen, mask: np.ndarray) -> dict[str, Any]:
    """Return the info in Gymnasium's layout: each column with a mask, 0 where the mask is false."""
    if not mask.any():
        return {}
    columns = [*zip(EVENTS, seen.events & mask, strict=True), ("cost", seen.cost * mask)]
    terms = zip(seat.terms, seen.terms * mask, strict=True)
    costs = zip(seat.costs, seen.costs * mask, strict=True)
    parts = {"rewards": _masked(terms, mask), "_rewards": mask, "costs": _masked(costs, mask), "_costs": mask}
    return _masked(columns, mask) | parts


def _masked(columns: Iterable[tuple[str, np.ndarray]], mask: np.ndarray) -> dict[str, np.ndarray]:
    masked = {}
    for name, column in columns:
        masked[name], masked[f"_{name}"] = column, mask
    return masked


def _with_final(seat: Seat, seen: Seen) -> dict[str, Any]:
    """Return the info with SAME_STEP: the last step's info is in ``final_info``, next to its ``final_obs``."""
    ended = seen.ended
    infos = _infos(seat, seen, ~ended)
    if ended.any() and seen.final is not None:
        last = np.full(len(ended), None, object)
        for place in np.flatnonzero(ended):
            last[place] = seen.final[place]
        infos |= {"final_obs": last, "_final_obs": ended}
        infos |= {"final_info": _infos(seat, seen, ended), "_final_info": ended}
    return infos


gymnasium.register(
    ID,
    entry_point="jaxwalk.adapters.gymnasium:StreetEnv",
    vector_entry_point="jaxwalk.adapters.gymnasium:StreetVectorEnv",
)

"""Stable-Baselines3: many streets as its vector environment. It needs the extra ``frameworks``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Unpack, cast

import numpy as np

try:
    from stable_baselines3.common.vec_env import VecEnv  # pyright: ignore[reportMissingImports] (not among the tools)
except ImportError as error:
    message = "jaxwalk.adapters.stable_baselines3 needs Stable-Baselines3: pip install 'jaxwalk[frameworks]'"
    raise ImportError(message) from error

from jaxwalk.adapters.game import EVENTS, WorldOptions
from jaxwalk.adapters.gymnasium import StreetVectorEnv
from jaxwalk.adapters.players import AdapterError, Weights
from jaxwalk.adapters.seat import Seen
from jaxwalk.interfaces import Policy

TOGETHER = "the streets are one environment, stepped at once"
"""Why nothing can be done to one of them."""


class StreetVecEnv(VecEnv):
    """Many streets in one compiled step, with Stable-Baselines3's interface: it drives the car in each of them.

    A seed (`seed`, or that of the agent) and ``set_options({"scenario": n})`` mean what they mean for
    `StreetVectorEnv`. The info of an episode's last step has ``terminal_observation``, ``TimeLimit.truncated``,
    ``goal``, ``collision``, ``timeout`` and ``is_success`` (it arrived), from which Stable-Baselines3 logs the share of
    successes; all other infos are empty, except for ``cost`` if costs are asked for.
    """

    def __init__(
        self,
        num_envs: int,
        *,
        observation: str = "route",
        pedestrians: str | Path | Policy = "always-go",
        reward: Weights = "fast",
        costs: Sequence[str] = (),
        **world: Unpack[WorldOptions],
    ) -> None:
        """Create ``num_envs`` streets; the other options are those of `StreetEnv`.

        ``costs``: names of the costs whose sum is the ``cost`` of each info; with none, infos have no cost.

        Raise ValueError for an impossible option; the message names it.
        """
        self.streets = StreetVectorEnv(
            num_envs, observation=observation, pedestrians=pedestrians, reward=reward, costs=costs,
            autoreset_mode="SameStep", **world,
        )  # fmt: skip
        self._actions = np.zeros((num_envs, 2), np.float32)
        super().__init__(num_envs, self.streets.single_observation_space, self.streets.single_action_space)

    def reset(self) -> np.ndarray:
        """Begin an episode in every street. Raise AdapterError for options that aren't the same for all of them."""
        if any(own != self._options[0] for own in self._options):
            raise AdapterError(f"options can't differ: {TOGETHER}; give one dictionary")
        observation, _ = self.streets.reset(seed=self._seeds[0], options=self._options[0])
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return observation

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions of the next step, ``(env, 2)``: acceleration and steering, as shares of their limits."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Make the step; an episode that ends begins anew, and its last observation is in its info."""
        seen = self.streets.seat.step(self._actions)
        return seen.observation, seen.reward.astype(np.float32), seen.ended, self._infos(seen)

    def _infos(self, seen: Seen) -> list[dict[str, Any]]:
        """Return the info of each street."""
        costs = seen.cost.tolist() if self.streets.seat.costs else None
        infos: list[dict[str, Any]] = [{} if costs is None else {"cost": costs[i]} for i in range(self.num_envs)]
        final = cast(np.ndarray, seen.final)  # there is one, since a street begins anew in the same step
        for place in np.flatnonzero(seen.ended).tolist():
            happened = dict(zip(EVENTS, seen.events[:, place].tolist(), strict=True))
            infos[place] |= happened
            infos[place]["is_success"] = happened["goal"]
            infos[place]["TimeLimit.truncated"] = bool(seen.truncated[place] and not seen.terminated[place])
            infos[place]["terminal_observation"] = final[place]
        return infos

    def close(self) -> None:
        """Close the streets."""
        self.streets.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the vector environment, once for each street."""
        return [getattr(self.streets, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raise AdapterError: what a street is, its options say when it is made."""
        raise AdapterError(f"{attr_name} can't be set: {TOGETHER}; make them with other options")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Raise AdapterError: no street has methods of its own."""
        raise AdapterError(f"{method_name} can't be called on single streets: {TOGETHER}; use `streets`")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return False for each street."""
        return [False] * len(list(self._get_indices(indices)))

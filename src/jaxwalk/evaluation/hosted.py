"""A driver that is not JAX, asked between the steps of a game."""

from __future__ import annotations

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.policies.host.driver import wrong_action


class Answered(eqx.Module):
    """A driver's answer of this step, as a policy of the compiled program."""

    action: Float[Array, "2 episode"]
    observes: str = eqx.field(static=True)

    @classmethod
    def nothing(cls, observes: str, batch: tuple[int, ...]) -> Answered:
        """Not asked yet."""
        return cls(jnp.zeros((2, *batch), jnp.float32), observes)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """It remembers nothing."""
        return None

    def act(
        self, key: Key[Array, "episode"], memory: None, observation: Float[Array, "feature episode"]
    ) -> tuple[Float[Array, "2 episode"], None]:
        """What was answered, whatever is observed."""
        return self.action, memory


def ask(
    driver: HostDriver, seen: Float[Array, "feature episode"], *,
    playing: Bool[np.ndarray, "episode"], numbers: Int[np.ndarray, "episode"], step: int,
) -> Answered:  # fmt: skip
    """The driver's answer to what it observes at a step.

    Raises DriverError, which names driver, scenario and step, for a driver that fails, or whose action in an episode
    still ``playing`` is impossible: of several scenarios (``numbers``) the first one is named.
    """
    try:
        action, _ = driver.act(None, None, seen)
    except DriverError as error:
        others = int(playing.sum()) - 1
        batch = f" and {others} others, played together" if others else ""
        raise driver.fail(f"{error} (scenario {numbers[playing][0]}{batch}, step {step})") from error
    wrong = wrong_action(np.asarray(action), playing)
    if wrong is not None:
        episode, what = wrong
        raise driver.fail(f"{what} (scenario {numbers[episode]}, step {step})")
    return Answered(action, driver.observes)

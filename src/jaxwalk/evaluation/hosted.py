"""Ask a driver that is not JAX for actions between the steps of a batch of episodes."""

from __future__ import annotations

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.acting import Given
from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.policies.host.driver import wrong_action


def ask(
    driver: HostDriver, seen: Float[Array, "feature episode"], *,
    playing: Bool[np.ndarray, "episode"], numbers: Int[np.ndarray, "episode"], step: int,
) -> Given:  # fmt: skip
    """Return the driver's answer to what it observes at a step.

    Raise DriverError, which names driver, scenario and step, if the driver fails, or if its action is impossible in an
    episode that is still ``playing``. If several scenarios (``numbers``) fail, it names the first.
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
    return Given(action)

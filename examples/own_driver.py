"""Play one trained driver in three forms, native, as an ONNX file and in plain NumPy, and compare how episodes end.

Small rounding differences can grow, so a few scenarios in a thousand may end differently. For each of these, the script
traces the gap between the actions. Run it with a number of scenarios: ``python own_driver.py 1000``.
"""

import sys
import tempfile
from pathlib import Path

import equinox as eqx
import numpy as np

from jaxwalk import Street
from jaxwalk.evaluation import evaluate, play
from jaxwalk.exports.onnx_policy import export
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, load_policy, shipped_policy
from jaxwalk.policies.host import HostDriver, load_host_driver
from jaxwalk.scenarios import Drawn

EPISODES = int(sys.argv[1]) if len(sys.argv) > 1 else 64
BATCH = min(EPISODES, 512)

street, people = Street.create(), AlwaysGo()
native = load_policy(shipped_policy("driver", "co-trained"), "driver")
decide = eqx.filter_jit(lambda policy, observation: policy.act(None, None, observation)[0])


class NumpyDriver:
    """Implements the whole protocol: the observation set, and an action for each row of a batch of observations."""

    observes = native.view.name

    def __init__(self):
        network = native.actor.network
        self.layers = [(np.asarray(w).T, np.asarray(b)) for w, b in zip(network.weights, network.biases, strict=True)]

    def act(self, observation):
        for weights, bias in self.layers[:-1]:
            observation = np.maximum(observation @ weights + bias, 0)
        weights, bias = self.layers[-1]
        return np.tanh(observation @ weights + bias)


class Beside:
    """Drives like another driver, and records the gap to the native driver's action at every step."""

    def __init__(self, driver):
        self.driver, self.gaps = driver, []

    def act(self, observation):
        seen = np.ascontiguousarray(observation.T)
        action = np.asarray(self.driver.act(None, None, seen)[0])
        self.gaps.append(np.abs(action - np.asarray(decide(native, seen))).max(axis=0))
        return action.T


def trace(driver, scenario):
    """Print the first gap between the actions of an episode at the same observation, and return the largest one."""
    first, row = scenario - scenario % BATCH, scenario % BATCH
    beside = Beside(driver)
    scenarios, keys = Drawn(street, 0).take(first + np.arange(BATCH))
    policies = {"driver": HostDriver("beside", beside, observes=driver.view.name), "pedestrian": people}
    played = play(street, policies, scenarios, keys)
    gaps = np.array(beside.gaps)[: played.length[row], row]
    step = int(np.argmax(gaps > 0))
    print(
        f"  scenario {scenario}: actions differ first at step {step}, by {gaps[step]:.1e}; at most by {gaps.max():.1e}"
    )
    return gaps.max()


def ending(rows):
    return np.select([rows[OUTCOMES].goal, rows[OUTCOMES].collision], ["goal", "collision"], "timeout")


with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "co-trained.onnx"
    print(f"exported; largest gap {export('co-trained', file, role='driver').gap:.1e}")
    drivers = [load_host_driver(str(file)), HostDriver("NumPy", NumpyDriver(), observes=NumpyDriver.observes)]

expected = ending(evaluate(street, {"driver": native, "pedestrian": people}, Drawn(street, 0, EPISODES), batch=BATCH))
for driver in drivers:
    found = ending(evaluate(street, {"driver": driver, "pedestrian": people}, Drawn(street, 0, EPISODES), batch=BATCH))
    ms = 1000 * driver.seconds_spent / driver.steps_made
    other = np.flatnonzero(found != expected)
    name = Path(driver.name).name
    print(f"{name}: the same ending in {np.mean(found == expected):.2%} of {EPISODES:,} scenarios, {ms:.2f} ms a step")
    gaps = [trace(driver, int(scenario)) for scenario in other]
    assert len(other) <= 0.005 * EPISODES and all(gap < 1e-4 for gap in gaps)

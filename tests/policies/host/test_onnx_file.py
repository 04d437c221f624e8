"""Out as ONNX and in again."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import TensorProto, helper

from jaxwalk.exports.onnx_model import onnx_model
from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.policies import LearnedPolicy
from jaxwalk.policies.host import DriverError, load_host_driver
from jaxwalk.sim.observation import size

ROUTE = size("driver", "route")


@eqx.filter_jit
def _loud_actor(seed, features, action, config):
    """One whose outputs differ: a fresh network's are nearly 0."""
    actor = make_actor(jax.random.key(seed), features, action, config)
    weights = (*actor.network.weights[:-1], actor.network.weights[-1] * 100.0)
    return eqx.tree_at(lambda a: a.network.weights, actor, weights)


@eqx.filter_jit
def _act(policy, *now):
    return policy.act(*now)


def _driver(noise="clipped", features=ROUTE):
    config = RoleConfig(actor_hidden=(8, 6), observes="route", noise=noise)
    return _loud_actor(0, features, Box(2), config)


def _write(path, content):
    path.write_bytes(content)
    return str(path)


@pytest.mark.parametrize("noise", ["clipped", "tanh"])
def test_a_driver_acts_in_onnx_as_it_did(tmp_path, noise):
    actor = _driver(noise)
    name = _write(tmp_path / "driver.onnx", onnx_model(actor, role="driver", metadata={"jaxwalk.seed": "3"}))
    driver = load_host_driver(name)
    seen = jax.random.normal(jax.random.key(2), (ROUTE, 7))
    expected, _ = _act(LearnedPolicy(actor, "driver"), jax.random.split(jax.random.key(5), 7), None, seen)
    found, _ = driver.act(None, None, seen)
    assert np.ptp(expected) > 0.5
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert driver.view.name == "route"
    told = {entry.key: entry.value for entry in onnx.load(name).metadata_props}
    assert told == {"jaxwalk.role": "driver", "jaxwalk.observes": "route", "jaxwalk.seed": "3"}


def test_pedestrians_choose_in_onnx_as_they_did():
    actor = _loud_actor(4, 3, Discrete(2), RoleConfig(actor_hidden=(8,)))
    seen = np.asarray(jax.random.normal(jax.random.key(2), (3, 12, 7)))
    expected, _ = _act(LearnedPolicy(actor, "driver"), jax.random.split(jax.random.key(5), 7), None, seen)
    expected = np.asarray(expected)
    action, logits = _run(actor, {"observation": seen.reshape(3, -1).T})
    assert 0 < expected.mean() < 1
    np.testing.assert_array_equal(action, expected.ravel())
    np.testing.assert_allclose(logits.T, np.asarray(eqx.filter_jit(actor.network)(seen)).reshape(2, -1), atol=1e-5)


def test_decisions_are_held_in_onnx_as_they_were():
    """Twelve steps, in which what there is to decide comes and goes; decisions stand for three."""
    config = RoleConfig(actor_hidden=(8,), gated=True, hold=3)
    actor = _loud_actor(1, 3, Discrete(2), config)
    policy = LearnedPolicy(actor, "driver")
    memory = policy.init((), (40,))
    held = {"choice": np.zeros(40, np.int32), "left": np.zeros(40, np.int32)}
    acted, noise, keys = [], np.random.default_rng(0), jax.random.split(jax.random.key(5), 40)
    for step in range(12):
        seen = noise.normal(size=(3, 40)).astype(np.float32)
        seen[0] = (np.arange(40) + step) % 7 > 1
        expected, memory = _act(policy, keys, memory, seen)
        action, _, choice, left = _run(actor, {"observation": seen.T, **held})
        np.testing.assert_array_equal(action, expected)
        np.testing.assert_array_equal(left, memory.steps_left)
        np.testing.assert_array_equal(choice, memory.choice)
        held = {"choice": choice, "left": left}
        acted.append(action)
    assert 0 < np.mean(acted) < 1


def _run(actor, given):
    session = onnxruntime.InferenceSession(onnx_model(actor, role="pedestrian", metadata={}))
    return session.run(None, {name: np.ascontiguousarray(x) for name, x in given.items()})


def _foreign(rows="rows", features: int | str = 34, kind=TensorProto.FLOAT):
    """A network of somebody else's: it returns the first two features."""
    seen = helper.make_tensor_value_info("x", kind, [rows, features])
    done = helper.make_tensor_value_info("y", kind, [rows, 2])
    columns = helper.make_tensor("columns", TensorProto.INT64, [2], [0, 1])
    graph = helper.make_graph(
        [helper.make_node("Gather", ["x", "columns"], ["y"], axis=1)], "g", [seen], [done], [columns]
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8).SerializeToString()


def test_without_metadata_the_size_says_what_it_observes(tmp_path):
    driver = load_host_driver(_write(tmp_path / "foreign.onnx", _foreign()))
    assert driver.view.name == "paper"
    action, _ = driver.act(None, None, jnp.asarray(np.arange(68, dtype=np.float32).reshape(34, 2)))
    np.testing.assert_array_equal(action, [[0, 1], [2, 3]])


def _no_text():
    """A network whose node has an operation's name that isn't UTF-8."""
    return _foreign().replace(b"Gather", b"Gath\xf4r")


WRONG = {
    "no text": (_no_text, "damaged or no ONNX file"),
    "nonsense": (lambda: b"nonsense", "damaged or no ONNX file"),
    "no set": (lambda: _foreign(features=7), r"takes 7 numbers; the sets' sizes are: paper 34, route 59"),
    "one row": (lambda: _foreign(rows=1), "with a free first axis and a fixed number of features"),
    "any size": (lambda: _foreign(features="n"), "with a free first axis and a fixed number of features"),
    "doubles": (lambda: _foreign(kind=TensorProto.DOUBLE), "must take one float32 array"),
    "people": (lambda: onnx_model(_driver(), role="pedestrian", metadata={}), "a network of the role pedestrian"),
    "other size": (
        lambda: onnx_model(_driver(features=34), role="driver", metadata={}),
        "takes 34 numbers and names the observation set 'route'",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_drive_is_refused(tmp_path, capsys, name):
    make, message = WRONG[name]
    with pytest.raises(DriverError, match=message):
        load_host_driver(_write(tmp_path / "wrong.onnx", make()))
    assert capsys.readouterr().out == ""

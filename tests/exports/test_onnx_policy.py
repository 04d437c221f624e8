from __future__ import annotations

import hashlib

import equinox as eqx
import jax
import numpy as np
import onnx
import pytest

from jaxwalk.exports import onnx_policy as exporting
from jaxwalk.exports.onnx_model import onnx_model
from jaxwalk.policies import PolicyError, shipped_policy


@pytest.fixture(autouse=True)
def briefly(monkeypatch):
    monkeypatch.setattr(exporting, "ENVIRONMENTS", 4)
    monkeypatch.setattr(exporting, "STEPS", 160)


@pytest.mark.parametrize(
    ("role", "name", "rows"),
    [("driver", "co-trained", 640), pytest.param("pedestrian", "learned", 640 * 12, marks=pytest.mark.long)],
)
def test_a_shipped_policy_is_written_and_knows_where_it_comes_from(tmp_path, role, name, rows):
    out = tmp_path / "there" / "policy.onnx"
    parity = exporting.export(name, out, role=role)
    assert (parity.rows, parity.other_choices) == (rows, 0)
    assert parity.gap < 1e-5  # badly compiled, both may round alike
    told = {entry.key.removeprefix("jaxwalk."): entry.value for entry in onnx.load(out).metadata_props}
    assert (told["role"], told["recipe"], told["seed"]) == (role, "fast", "50")
    assert told["policy_sha256"] == hashlib.sha256(shipped_policy(role, name).read_bytes()).hexdigest()


def seen_once(street, role, policy):
    """Three made-up observations and what the policy does."""
    seen = jax.random.normal(jax.random.key(0), (policy.actor.network.weights[0].shape[1], 3))
    action, _ = policy.act(jax.random.split(jax.random.key(0), 3), None, seen)
    return exporting.Met(np.asarray(seen), None, np.asarray(action), np.asarray(policy.actor.network(seen)))


def test_what_acts_otherwise_is_not_written(tmp_path, monkeypatch):
    def other(actor, **about):
        bias = actor.network.biases[-1]
        return onnx_model(eqx.tree_at(lambda a: a.network.biases[-1], actor, bias + 0.01), **about)

    monkeypatch.setattr(exporting, "onnx_model", other)
    monkeypatch.setattr(exporting, "met", seen_once)
    with pytest.raises(PolicyError, match=r"co-trained: in ONNX it acts otherwise \(largest gap .*was not written"):
        exporting.export("co-trained", tmp_path / "policy.onnx", role="driver")
    assert list(tmp_path.iterdir()) == []

"""Stable-Baselines3 agents: the usual ones without unpickling, others if they are trusted."""

from __future__ import annotations

import base64
import json
import os
import pickle
import zipfile

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.policies.host import DriverError, load_host_driver

pytest.importorskip("stable_baselines3")
gymnasium = pytest.importorskip("gymnasium")


class Empty(gymnasium.Env):
    """Spaces, and nothing else."""

    def __init__(self, features, highest=1.0):
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (features,), np.float32)
        self.action_space = gymnasium.spaces.Box(-highest, highest, (2,), np.float32)


def _agent(path, kind="PPO", features=59, highest=1.0, **options):
    import stable_baselines3

    agent = getattr(stable_baselines3, kind)("MlpPolicy", Empty(features, highest), seed=0, device="cpu", **options)
    agent.save(path)
    return agent


def _check(driver, agent, features=59):
    seen = 3 * np.random.default_rng(0).normal(size=(features, 5)).astype(np.float32)
    expected, _ = agent.predict(seen.T, deterministic=True)
    np.testing.assert_allclose(driver.act(None, None, jnp.asarray(seen))[0].T, expected, atol=1e-6)


@pytest.mark.parametrize(("features", "observes"), [(59, "route"), (34, "paper")])
@pytest.mark.parametrize("kind", ["PPO", "A2C"])
def test_a_usual_agent_needs_no_trust(tmp_path, kind, features, observes):
    agent = _agent(tmp_path / "agent.zip", kind, features)
    driver = load_host_driver(str(tmp_path / "agent.zip"))
    assert driver.view.name == observes
    _check(driver, agent, features)


def test_its_layers_and_activation_are_its_own(tmp_path):
    from torch import nn

    policy = {"activation_fn": nn.ReLU, "net_arch": [7, 6, 5]}
    agent = _agent(tmp_path / "agent.zip", policy_kwargs=policy)
    _check(load_host_driver(str(tmp_path / "agent.zip")), agent)


@pytest.mark.parametrize("unusual", ["activation", "network", "algorithm"])
def test_an_unusual_agent_needs_trust(tmp_path, unusual):
    from torch import nn

    kind = "SAC" if unusual == "algorithm" else "PPO"
    options = {"activation": {"activation_fn": nn.ELU}, "network": {"squash_output": True}}.get(unusual)
    more = {"use_sde": True} if unusual == "network" else {}
    agent = _agent(tmp_path / "agent.zip", kind, **({"policy_kwargs": options} if options else {}), **more)
    with pytest.raises(DriverError, match=r"so it can't be loaded without unpickling.*--trust"):
        load_host_driver(str(tmp_path / "agent.zip"))
    _check(load_host_driver(str(tmp_path / "agent.zip"), trust=True), agent)


class Bomb:
    def __init__(self, folder):
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


def test_nothing_is_unpickled_without_trust(tmp_path):
    _agent(tmp_path / "agent.zip")
    bomb = base64.b64encode(pickle.dumps(Bomb(tmp_path / "exploded"))).decode()
    with zipfile.ZipFile(tmp_path / "agent.zip") as old, zipfile.ZipFile(tmp_path / "bomb.zip", "w") as new:
        data = json.loads(old.read("data"))
        data["policy_kwargs"] = {":type:": "dict", ":serialized:": bomb}
        new.writestr("data", json.dumps(data))
        for name in ("policy.pth", "pytorch_variables.pth", "_stable_baselines3_version"):
            new.writestr(name, old.read(name))
    assert load_host_driver(str(tmp_path / "bomb.zip")).view.name == "route"
    assert not (tmp_path / "exploded").exists()


def test_other_actions_are_refused(tmp_path):
    _agent(tmp_path / "agent.zip", highest=2.0)
    with pytest.raises(DriverError, match=r"its actions lie between \[-2. -2.\] and \[2. 2.\]"):
        load_host_driver(str(tmp_path / "agent.zip"))


def test_other_observations_are_refused(tmp_path):
    _agent(tmp_path / "agent.zip", features=10)
    with pytest.raises(DriverError, match=r"takes 10 numbers; the sets' sizes are"):
        load_host_driver(str(tmp_path / "agent.zip"))


def test_another_zip_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("readme", "hello")
    (tmp_path / "nonsense.zip").write_bytes(b"nonsense")
    for name in ("other.zip", "nonsense.zip"):
        with pytest.raises(DriverError, match="damaged or no Stable-Baselines3 agent"):
            load_host_driver(str(tmp_path / name))

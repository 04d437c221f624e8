"""PyTorch files: what is safe loads, what could run code does not without being told."""

from __future__ import annotations

import os
import warnings

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.policies.host import DriverError, load_host_driver

torch = pytest.importorskip("torch")


class Bomb:
    """Unpickled, it leaves a folder behind."""

    def __init__(self, folder):
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


@pytest.fixture
def network():
    torch.manual_seed(0)
    return torch.nn.Sequential(torch.nn.Linear(59, 8), torch.nn.Linear(8, 2), torch.nn.Tanh()).eval()


@pytest.fixture
def script(network, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.script(network).save(str(tmp_path / "script.pt"))
    return str(tmp_path / "script.pt")


def _check(driver, network):
    seen = np.random.default_rng(0).normal(size=(59, 5)).astype(np.float32)
    expected = network(torch.from_numpy(seen.T.copy())).detach().numpy()
    np.testing.assert_allclose(driver.act(None, None, jnp.asarray(seen))[0].T, expected, atol=1e-6)
    assert driver.view.name == "route"


def test_torchscript_needs_no_trust(script, network):
    _check(load_host_driver(script), network)


@pytest.mark.parametrize("kind", ["script.pt", "exported.pt2"])
def test_the_file_may_name_what_it_observes(tmp_path, kind):
    network = torch.nn.Sequential(torch.nn.Linear(65, 2), torch.nn.Tanh()).eval()  # two sets have 65 features
    path, named = str(tmp_path / kind), {"observes": "route-belief"}
    if kind == "script.pt":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            torch.jit.script(network).save(path, _extra_files=named)
    else:
        torch.export.save(torch.export.export(network, (torch.zeros(4, 65),)), path, extra_files=named)
    assert load_host_driver(path, trust=kind == "exported.pt2").view.name == "route-belief"


def test_a_set_must_be_named_if_the_size_does_not_say(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.script(torch.nn.Linear(65, 2)).save(str(tmp_path / "script.pt"))
    with pytest.raises(DriverError, match=r"takes 65 numbers; the sets' sizes are: .*route-belief 65.*name one in it"):
        load_host_driver(str(tmp_path / "script.pt"))


def test_a_pickled_module_needs_trust(tmp_path, network):
    path = tmp_path / "pickled.pt"
    torch.save(network, path)
    with pytest.raises(DriverError, match=r"pickled.pt: a PyTorch file of pickled objects, which can run any code"):
        load_host_driver(str(path))
    _check(load_host_driver(str(path), trust=True), network)


def test_nothing_is_unpickled_without_trust(tmp_path):
    path, folder = tmp_path / "bomb.pt", tmp_path / "exploded"
    torch.save(Bomb(folder), path)
    with pytest.raises(DriverError, match="--trust"):
        load_host_driver(str(path))
    assert not folder.exists()
    with pytest.raises(DriverError):
        load_host_driver(str(path), trust=True)
    assert folder.exists()  # so the bomb was one


def test_torch_export_needs_trust(tmp_path, network):
    path = tmp_path / "exported.pt2"
    rows = torch.export.Dim("rows")
    torch.export.save(torch.export.export(network, (torch.zeros(4, 59),), dynamic_shapes=({0: rows},)), path)
    with pytest.raises(DriverError, match=r"a torch.export archive, which can run any code"):
        load_host_driver(str(path))
    _check(load_host_driver(str(path), trust=True), network)


def test_weights_alone_are_no_driver(tmp_path, network):
    torch.save(network.state_dict(), tmp_path / "weights.pt")
    with pytest.raises(DriverError, match="holds weights without a network"):
        load_host_driver(str(tmp_path / "weights.pt"), trust=True)


def test_a_damaged_file_is_said_to_be(tmp_path, script):
    content = bytearray((tmp_path / "script.pt").read_bytes())
    place = content.index(b"constants.pkl")
    content[place + 13 : place + 60] = bytes(47)
    (tmp_path / "damaged.pt").write_bytes(content)
    with pytest.raises(DriverError, match=r"damaged.pt: can't be loaded as TorchScript"):
        load_host_driver(str(tmp_path / "damaged.pt"))

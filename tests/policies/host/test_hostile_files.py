"""Crafted drivers: without trust they can't touch files, read outside their folder, or fill memory."""

from __future__ import annotations

import io
import json
import os
import warnings
import zipfile
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import onnxruntime
import pytest
from onnx import TensorProto, helper, numpy_helper

from jaxwalk.policies.host import DriverError, load_host_driver
from jaxwalk.sim.observation import size

ROUTE = size("driver", "route")
MEMORY = Path("/proc/self/statm")


SCRIPT = """
import torch

class Scripted(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.layer = torch.nn.Linear(FEATURES, 2)

    def forward(self, x):
        REACH
        return self.layer(x)
"""


def _scripted(path, reach):
    """A network as TorchScript, which does something else, too. (PyTorch compiles a class from its source file.)"""
    torch = pytest.importorskip("torch")
    source = path.with_suffix(".txt")
    source.write_text(SCRIPT.replace("REACH", reach).replace("FEATURES", str(ROUTE)))
    made: dict = {}
    exec(compile(source.read_text(), str(source), "exec"), made)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.script(made["Scripted"]()).save(str(path))
    source.unlink()
    return str(path)


def _replaced(path, old, new):
    """The same archive with other bytes, of the same length, in its code or the names of its records."""
    with zipfile.ZipFile(path) as archive:
        content = [(x.filename, archive.read(x)) for x in archive.infolist()]
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content:
            is_code = name.lower().endswith(".py")
            archive.writestr(name.replace(old, new), data.replace(old.encode(), new.encode()) if is_code else data)
    return str(path)


SAVES, NAMED = "torch.save(x, 'stolen')", ("torch.save(", 'getattr(torch, "sav\\145")(')
REACHES = {
    "save": (SAVES, (), "save"),
    "from_file": ("x = x + torch.from_file('secret', True, 4).sum()", (), "from_file"),
    "another case": (SAVES, ("__torch__.py", "__torch__.PY"), "save"),
    "an escape": (SAVES, NAMED, "getattr"),
    "an alias": (SAVES, ("torch.save(", "t = torch\n    t.save("), "save"),
    "a method": (SAVES, ("torch.save(x, ", "x.save("), "save"),
    "a default": (
        SAVES,
        ("x: Tensor)", "x: Tensor, y: Optional[Tensor]=torch.load_tensor('f'))"),
        "(load_tensor|save)",
    ),
    "getattr": (SAVES, ("torch.save(", "g = getattr\n    g(torch, 'x')("), "getattr"),
    "operations of others": (SAVES, ("torch.save(", "ops.quantized.add("), "ops"),
    "a backslash": ("print('stolen')", ("stolen", r"\163tolen"), r"\\"),
    "a library": (SAVES, ("torch.save(", "__torch__.torch.classes.x.Y("), "classes"),
}


@pytest.mark.parametrize("name", REACHES)
def test_torchscript_that_touches_files_takes_trust(tmp_path, monkeypatch, name):
    reach, change, called = REACHES[name]
    monkeypatch.chdir(tmp_path)
    file = _scripted(tmp_path / "thief.pt", reach)
    if change:
        _replaced(tmp_path / "thief.pt", *change)
    with pytest.raises(DriverError, match=rf"its TorchScript uses {called}, which may do more than compute"):
        load_host_driver(file)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["thief.pt"]
    if name in ("save", "another case", "an escape"):  # so these would have run
        driver = load_host_driver(file, trust=True)
        driver.act(None, None, jnp.zeros((ROUTE, 1)))
        assert (tmp_path / "stolen").exists()


def test_torchscript_of_other_kinds(tmp_path):
    """A record of the first versions can name any other as code; a class in C++ can hide in the weights' record."""
    file = _scripted(tmp_path / "old.pt", "x = x + 0")
    assert load_host_driver(file).view.name == "route"
    for record, content, message in (
        ("MODEL.json", b"{}", "an old TorchScript file"),
        ("other.pkl", b"c__torch__.torch\nclasses.x\n", "uses classes"),
    ):
        again = _scripted(tmp_path / "again.pt", "x = x + 0")
        with zipfile.ZipFile(again, "a") as archive:
            archive.writestr(f"again/{record}", content)
        with pytest.raises(DriverError, match=message):
            load_host_driver(again)


def test_records_whose_names_are_no_text(tmp_path):
    honest = _scripted(tmp_path / "honest.pt", "x = x + 0")
    content = Path(_replaced(honest, "byteorder", "byteorder")).read_bytes()  # (not marked as UTF-8)
    (tmp_path / "strange.pt").write_bytes(content.replace(b"byteorder", b"byte\xe1rder"))
    with pytest.raises(DriverError, match=r"strange\.pt: can't be loaded as TorchScript"):
        load_host_driver(str(tmp_path / "strange.pt"))


def test_a_name_that_is_no_text_is_told_with_its_file(tmp_path):
    file = _scripted(tmp_path / "named.pt", "x = x + 0")
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr("named/extra/observes", b"\xff\xfe")
    with pytest.raises(DriverError, match=r"named\.pt: takes 59 numbers and names the observation set"):
        load_host_driver(file)


@pytest.mark.parametrize("location", ["../secret", "secret"])
def test_weights_of_onnx_lie_in_its_own_folder(tmp_path, location):
    """Beside the file they may lie; above it there may be a secret."""
    inside = tmp_path / "inside"
    inside.mkdir()
    for folder in (tmp_path, inside):
        np.zeros((ROUTE, 2), np.float32).tofile(folder / "secret")
    weights = TensorProto(name="w", data_type=TensorProto.FLOAT, dims=[ROUTE, 2], data_location=TensorProto.EXTERNAL)
    weights.external_data.add(key="location", value=location)
    ends = [helper.make_tensor_value_info(*x) for x in (("x", 1, ["n", ROUTE]), ("y", 1, ["n", 2]))]
    graph = helper.make_graph([helper.make_node("MatMul", ["x", "w"], ["y"])], "g", ends[:1], ends[1:], [weights])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    (inside / "driver.onnx").write_bytes(model.SerializeToString())
    if location == "secret":
        assert load_host_driver(str(inside / "driver.onnx")).view.name == "route"
        return
    with pytest.raises(DriverError, match=r"driver\.onnx: damaged or no ONNX file"):
        load_host_driver(str(inside / "driver.onnx"))


def test_an_onnx_runtime_that_reads_other_files_is_not_used(tmp_path, monkeypatch):
    (tmp_path / "driver.onnx").write_bytes(b"anything")
    monkeypatch.setattr(onnxruntime, "__version__", "1.20.1")
    with pytest.raises(DriverError, match=r"driver\.onnx: ONNX Runtime 1\.20\.1 lets a file read others; update it"):
        load_host_driver(str(tmp_path / "driver.onnx"))


@pytest.mark.skipif(not MEMORY.is_file(), reason="the system doesn't say how much memory a process has")
def test_no_constant_of_an_onnx_file_is_computed_while_it_is_loaded(tmp_path):
    """200 bytes that stand for 400 MB, of which the network takes one number, by what it observes."""
    count = numpy_helper.from_array(np.array([100_000_000]), "count")
    zero = numpy_helper.from_array(np.zeros((ROUTE, 2), np.float32), "w")
    nodes = [
        helper.make_node("ConstantOfShape", ["count"], ["many"]),
        helper.make_node("MatMul", ["x", "w"], ["y0"]),
        helper.make_node("Cast", ["y0"], ["place"], to=TensorProto.INT64),
        helper.make_node("Gather", ["many", "place"], ["y"]),
    ]
    ends = [helper.make_tensor_value_info(*x) for x in (("x", 1, ["n", ROUTE]), ("y", 1, ["n", 2]))]
    graph = helper.make_graph(nodes, "g", ends[:1], ends[1:], [count, zero])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    (tmp_path / "driver.onnx").write_bytes(model.SerializeToString())
    before = _resident()
    driver = load_host_driver(str(tmp_path / "driver.onnx"))
    assert driver.view.name == "route"
    assert _resident() - before < 200_000_000


def _resident():
    """Bytes of memory that this process has."""
    return int(MEMORY.read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def _agent(path, data, weights):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data", data)
        archive.writestr("policy.pth", weights)
    return str(path)


SPACE = {"action_space": {"low": "[-1. -1.]", "high": "[1. 1.]"}}


def test_an_archive_that_would_fill_memory(tmp_path, monkeypatch):
    from jaxwalk.policies.host import torch_file

    monkeypatch.setattr(torch_file, "MOST_BYTES", 10_000_000)
    with pytest.raises(DriverError, match=r"unpacked it has 20,000,\d+ bytes; a driver has at most 10,000,000"):
        load_host_driver(_agent(tmp_path / "bomb.zip", b" " * 20_000_000, b""))
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("archive/data/0", b"\0" * 20_000_000)
    with pytest.raises(DriverError, match="unpacked it has"):
        load_host_driver(_agent(tmp_path / "nested.zip", json.dumps(SPACE), inner.getvalue()))


@pytest.mark.parametrize(
    "data", ["[" * 20_000, "9" * 5_000, '{"a": ', "[]", '{"action_space": 3}', "\ud800"], ids=range(6)
)
def test_a_damaged_agent(tmp_path, data):
    inner = io.BytesIO()
    zipfile.ZipFile(inner, "w").close()
    with pytest.raises(DriverError, match=r"agent\.zip: (damaged|its actions)"):
        load_host_driver(_agent(tmp_path / "agent.zip", data.encode("utf-8", "surrogatepass"), inner.getvalue()))


def test_weights_that_repeat_one_number_are_not_believed(tmp_path):
    """A view of one number can have as many rows as it likes, and fill memory when it is used."""
    torch = pytest.importorskip("torch")
    inner = io.BytesIO()
    torch.save({"action_net.weight": torch.zeros(1, 1).expand(2, ROUTE), "action_net.bias": torch.zeros(2)}, inner)
    with pytest.raises(DriverError, match="its weights hold more than matrices and vectors by name"):
        load_host_driver(_agent(tmp_path / "agent.zip", json.dumps(SPACE), inner.getvalue()))


@pytest.mark.parametrize("called", ["builtins\nbytearray", "torch\nDoubleStorage"])
def test_weights_that_would_make_something_large(tmp_path, called):
    """PyTorch allows a bytearray, of any size: 90 bytes that stand for 300 MB."""
    torch = pytest.importorskip("torch")
    inner = io.BytesIO()
    torch.save({}, inner)
    pickled = b"\x80\x02c" + called.encode() + b"\nJ\x00\xa3\xe1\x11\x85R."
    weights = io.BytesIO()
    with zipfile.ZipFile(inner) as old, zipfile.ZipFile(weights, "w") as new:
        for name in old.namelist():
            new.writestr(name, pickled if name.endswith("data.pkl") else old.read(name))
    with pytest.raises(DriverError, match=f"its weights call {' '.join(called.split())}, so it can't be loaded"):
        load_host_driver(_agent(tmp_path / "agent.zip", json.dumps(SPACE), weights.getvalue()))


def test_weights_before_which_something_stands(tmp_path):
    """An archive to Python, but to PyTorch the pickles of an old file."""
    torch = pytest.importorskip("torch")
    new, old = io.BytesIO(), io.BytesIO()
    torch.save({}, new)
    torch.save({}, old, _use_new_zipfile_serialization=False)
    with pytest.raises(DriverError, match="its weights are in an old format"):
        load_host_driver(_agent(tmp_path / "agent.zip", json.dumps(SPACE), old.getvalue() + new.getvalue()))

"""Drivers in files of other frameworks: a small good one of each kind, and ways to spoil it inside its archive."""

from __future__ import annotations

import io
import json
import warnings
import zipfile
from typing import Any

import numpy as np
from hypothesis import strategies as st

from hostile.mutations import Files, as_json, damaged, documents

FEATURES = 59
"""Of the observation set ``route``."""
ABOUT = {"action_space": {"low": "[-1. -1.]", "high": "[1. 1.]"}, "policy_kwargs": {}}
"""What an agent of Stable-Baselines3's says of itself."""


def onnx_network() -> bytes:
    """A layer as ONNX."""
    from onnx import helper, numpy_helper

    ends = [helper.make_tensor_value_info(*x) for x in (("x", 1, ["n", FEATURES]), ("y", 1, ["n", 2]))]
    weights = [numpy_helper.from_array(np.zeros((FEATURES, 2), np.float32), "w")]
    nodes = [helper.make_node("MatMul", ["x", "w"], ["z"]), helper.make_node("Tanh", ["z"], ["y"])]
    graph = helper.make_graph(nodes, "g", ends[:1], ends[1:], weights)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8).SerializeToString()


def spoiled_onnx(good: bytes) -> st.SearchStrategy[bytes | None]:
    """A sound message that says something else; None if there is no such message."""
    from google.protobuf import json_format
    from onnx import ModelProto

    def write(document: Any) -> bytes | None:
        try:
            return json_format.ParseDict(document, ModelProto()).SerializeToString()
        except (json_format.ParseError, TypeError, ValueError, AttributeError):
            return None

    return documents(json_format.MessageToDict(ModelProto.FromString(good))).map(write)


def torchscript_network() -> bytes:
    """Two layers as TorchScript."""
    import torch

    written, network = io.BytesIO(), torch.nn.Sequential(torch.nn.Linear(FEATURES, 2), torch.nn.Tanh())
    for weights in network.parameters():  # so that the same file is spoiled each time
        torch.nn.init.zeros_(weights)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.save(torch.jit.script(network.eval()), written)
    return written.getvalue()


def agent() -> bytes:
    """The parts of a Stable-Baselines3 agent that are read."""
    import torch

    written, shapes = io.BytesIO(), {"mlp_extractor.policy_net.0": (4, FEATURES), "action_net": (2, 4)}
    weights = {f"{name}.weight": torch.zeros(shape) for name, shape in shapes.items()}
    weights |= {f"{name}.bias": torch.zeros(shape[0]) for name, shape in shapes.items()}
    torch.save(weights, written)
    return packed({"data": json.dumps(ABOUT).encode(), "policy.pth": written.getvalue()})


def spoiled_agent(good: bytes) -> st.SearchStrategy[bytes]:
    """Another description, or something wrong inside its weights' archive."""
    inside = unpacked(good)
    told = documents(ABOUT).map(lambda about: packed({**inside, "data": as_json(about)}))
    return told | spoiled_archive(inside["policy.pth"]).map(lambda x: packed({**inside, "policy.pth": x}))


def spoiled_archive(good: bytes) -> st.SearchStrategy[bytes]:
    """A sound archive, of which a record has wrong bytes or is missing."""
    return damaged(unpacked(good)).map(packed)


def unpacked(content: bytes) -> dict[str, bytes]:
    """The records of an archive."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(records: Files) -> bytes:
    """An archive of records."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as archive:
        for name, content in records.items():
            archive.writestr(name, content)
    return written.getvalue()

"""A trained network as an ONNX file, which computes the most likely action of `LearnedPolicy`.

Each row of the inputs is one agent. A driver maps ``observation (rows, features)`` to ``action (rows, 2)``. Pedestrians
map it to ``action (rows,)`` (0 waits, 1 goes) and ``logits (rows, 2)``, from which a caller may draw. A policy that
holds its decisions has its memory as inputs ``choice`` and ``left``, both (rows,) and 0 at the start of an episode, and
as outputs ``next_choice`` and ``next_left``.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np

from jaxwalk.learning.actor import DISCRETE, GATED, OTHERWISE, Actor
from jaxwalk.policies.learned import PolicyError

OPSET, IR = 17, 8
"""Versions of ONNX, which every ONNX Runtime since 2022 reads."""


def onnx_model(actor: Actor, *, role: str, metadata: Mapping[str, str]) -> bytes:
    """Return the content of the file. Its metadata has ``jaxwalk.role``, ``jaxwalk.observes`` and the given entries.

    Raises PolicyError if the package onnx isn't installed.
    """
    onnx = _onnx()
    features = actor.network.sizes[0]
    graph = _Graph(onnx)
    graph.input("observation", onnx.TensorProto.FLOAT, features)
    outputs = _layers(graph, actor)
    if actor.kind in (DISCRETE, GATED):
        _choose(graph, actor, outputs)
    else:
        graph.add("Tanh", [outputs], "action")
        graph.output("action", onnx.TensorProto.FLOAT, actor.network.sizes[-1])
    entries = {"jaxwalk.role": role, "jaxwalk.observes": actor.observes, **metadata}
    return graph.model(f"jaxwalk {role}", entries).SerializeToString()


def _onnx() -> Any:
    try:
        return import_module("onnx")
    except ImportError as error:
        raise PolicyError("writing ONNX needs the package onnx: pip install 'jaxwalk[onnx]'") from error


class _Graph:
    """An ONNX graph under construction."""

    def __init__(self, onnx: Any) -> None:
        self.onnx, self._nodes, self._constants, self._inputs, self._outputs = onnx, [], [], [], []

    def input(self, name: str, kind: int, *shape: int) -> None:
        self._inputs.append(self.onnx.helper.make_tensor_value_info(name, kind, ["rows", *shape]))

    def output(self, name: str, kind: int, *shape: int) -> None:
        self._outputs.append(self.onnx.helper.make_tensor_value_info(name, kind, ["rows", *shape]))

    def constant(self, name: str, value: Any, dtype: type = np.int32) -> str:
        """Add a named constant and return its name."""
        self._constants.append(self.onnx.numpy_helper.from_array(np.array(value, dtype), name))
        return name

    def add(self, operation: str, inputs: list[str], output: str, **attributes: Any) -> str:
        """Add an operation with one output and return the output's name."""
        self._nodes.append(self.onnx.helper.make_node(operation, inputs, [output], **attributes))
        return output

    def model(self, name: str, metadata: Mapping[str, str]) -> Any:
        """Return the whole model, after the package onnx has checked it."""
        helper = self.onnx.helper
        graph = helper.make_graph(self._nodes, name, self._inputs, self._outputs, self._constants)
        opset = helper.make_opsetid("", OPSET)
        model = helper.make_model(graph, opset_imports=[opset], ir_version=IR, producer_name="jaxwalk")
        helper.set_model_props(model, dict(metadata))
        self.onnx.checker.check_model(model, full_check=True)
        return model


def _layers(graph: _Graph, actor: Actor) -> str:
    """Add the network and return the name of its outputs, ``(rows, outputs)``."""
    x, last = "observation", len(actor.network.weights) - 1
    for i, (weight, bias) in enumerate(zip(actor.network.weights, actor.network.biases, strict=True)):
        weights = [graph.constant(f"weight{i}", weight, np.float32), graph.constant(f"bias{i}", bias, np.float32)]
        name = "logits" if i == last else f"layer{i}"
        x = graph.add("Gemm", [x, *weights], name, transB=1)
        x = x if i == last else graph.add("Relu", [x], f"relu{i}")
    return x


def _choose(graph: _Graph, actor: Actor, logits: str) -> None:
    """Add the most likely choice; a gated policy holds it, as `jaxwalk.learning.actor.decide` does."""
    integer = graph.onnx.TensorProto.INT32
    gated = actor.kind == GATED
    likeliest = graph.add("ArgMax", [logits], "likeliest", axis=1, keepdims=0)
    new = graph.add("Cast", [likeliest], "new" if gated else "action", to=integer)
    graph.output("action", integer)
    graph.output("logits", graph.onnx.TensorProto.FLOAT, actor.network.sizes[-1])
    if not gated:
        return
    for name in ("choice", "left"):
        graph.input(name, integer)
    zero, one = graph.constant("zero", 0), graph.constant("one", 1)
    column = graph.add("Gather", ["observation", zero], "column", axis=1)
    may = graph.add("Greater", [column, graph.constant("threshold", 0, np.float32)], "may")
    now = graph.add("And", [may, graph.add("Equal", ["left", zero], "free")], "now")
    kept = graph.add("Where", [now, new, "choice"], "next_choice")
    graph.add("Where", [may, kept, graph.constant("otherwise", OTHERWISE)], "action")
    later = graph.add("Sub", ["left", one], "later")
    left = graph.add("Where", [now, graph.constant("hold", actor.hold - 1), later], "counted")
    graph.add("Where", [may, left, zero], "next_left")
    for name in ("next_choice", "next_left"):
        graph.output(name, integer)

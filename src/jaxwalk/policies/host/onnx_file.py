"""A driver in an ONNX file: one input ``(episodes, features)``, whose first output is the action ``(episodes, 2)``.

The entry ``jaxwalk.observes`` of its metadata names the observation set. ONNX is a list of operations: no Python code.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.policies.host.driver import DriverError
from jaxwalk.policies.host.load import set_of_size

OBSERVES, ROLE = "jaxwalk.observes", "jaxwalk.role"
"""Entries of an ONNX file's metadata."""
OLDEST = (1, 24)
"""Versions of ONNX Runtime before this read weights outside the file's folder."""


class OnnxDriver:
    """Runs the network with ONNX Runtime on the processor."""

    def __init__(self, session: Any) -> None:
        self._session, self._input = session, session.get_inputs()[0].name
        self._output = session.get_outputs()[0].name

    def act(self, observation: np.ndarray) -> np.ndarray:
        """The network's first output."""
        (action,) = self._session.run([self._output], {self._input: observation})
        return action


def load(path: Path, *, trust: bool) -> tuple[OnnxDriver, str]:
    """The driver and its observation set. It needs no ``trust``.

    Raises DriverError for a file that is no network of this form.
    """
    try:
        import onnxruntime
    except ImportError as error:
        raise DriverError(f"{path}: ONNX needs ONNX Runtime: pip install 'jaxwalk[onnx]'") from error
    version = onnxruntime.__version__
    if tuple(map(int, version.split(".")[:2])) < OLDEST:
        raise DriverError(
            f"{path}: ONNX Runtime {version} lets a file read others; update it: pip install -U 'jaxwalk[onnx]'"
        )
    try:  # (without folding constants, which may be of any size, while it is loaded)
        session = onnxruntime.InferenceSession(
            str(path),
            providers=["CPUExecutionProvider"],
            disabled_optimizers=["ConstantFolding"],
            enable_fallback=0,  # (which prints, and tries the same again)
        )
    except Exception as error:  # (ONNX Runtime's own errors have no common class but this)
        raise DriverError(f"{path}: damaged or no ONNX file ({error}); export it again") from error
    metadata = session.get_modelmeta().custom_metadata_map
    if metadata.get(ROLE, "driver") != "driver":
        raise DriverError(f"{path}: is a network of the role {metadata[ROLE]}, not of a driver; export the driver")
    inputs = session.get_inputs()
    shapes = ", ".join(f"{x.name} {x.type} {x.shape}" for x in inputs)
    if len(inputs) != 1 or inputs[0].type != "tensor(float)" or len(inputs[0].shape) != 2:
        raise DriverError(f"{path}: takes {shapes}; it must take one float32 array (episodes, features)")
    rows, features = inputs[0].shape
    if isinstance(rows, int) or not isinstance(features, int):
        raise DriverError(f"{path}: takes {shapes}; export it with a free first axis and a fixed number of features")
    return OnnxDriver(session), set_of_size(path, features, metadata.get(OBSERVES))

"""A driver in an ONNX file: its one input is ``(episodes, features)``, its first output the action ``(episodes, 2)``.

The metadata's entry ``jaxwalk.observes`` names the observation set. ONNX is a list of operations, without Python code.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.policies.host.driver import DriverError
from jaxwalk.policies.host.loaders import set_of_size

OBSERVES, ROLE = "jaxwalk.observes", "jaxwalk.role"
"""Entries of an ONNX file's metadata."""
OLDEST = (1, 24)
"""The oldest safe version of ONNX Runtime: older ones read weights from outside the file's folder."""


class OnnxDriver:
    """Runs the network with ONNX Runtime on the CPU."""

    def __init__(self, session: Any) -> None:
        self._session, self._input = session, session.get_inputs()[0].name
        self._output = session.get_outputs()[0].name

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Return the network's first output."""
        (action,) = self._session.run([self._output], {self._input: observation})
        return action


def load(path: Path, *, trust: bool) -> tuple[OnnxDriver, str]:
    """Return the driver and its observation set; ``trust`` makes no difference, because ONNX holds no Python code.

    Raises DriverError if the file isn't a network of this form.
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
    try:  # constants may be of any size when they are folded during loading, so they are not folded
        session = onnxruntime.InferenceSession(
            str(path),
            providers=["CPUExecutionProvider"],
            disabled_optimizers=["ConstantFolding"],
            enable_fallback=0,  # the fallback prints and tries the same again
        )
    except Exception as error:  # ONNX Runtime's errors have no other common class
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

"""A driver in a PyTorch file: a module that takes ``(episodes, features)`` and returns the action ``(episodes, 2)``.

PyTorch's own reader loads TorchScript. It knows only tensors and TorchScript operations, and unpickles no Python
objects. But some operations reach beyond the network, such as ``torch.save``, and loading already runs some code
(defaults of arguments). So the code is checked before it is loaded: anything but a network's operations needs
``trust``. Everything else (`torch.export`, whole modules by `torch.save`) can run any Python code while it is loaded
and needs ``trust``: `torch.export.load` unpickles some weights, and evaluates expressions for the shapes.
"""

from __future__ import annotations

import re
import warnings
import zipfile
import zlib
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.policies.host.driver import DriverError
from jaxwalk.policies.host.loaders import set_of_size

OBSERVES = "observes"
"""The extra file of an archive that names the observation set (``_extra_files``, ``extra_files``)."""
WAY_OUT = "give it as ONNX or plain TorchScript instead, or say --trust if you know where it comes from"

MOST_BYTES = 2**30
"""Largest size of an unpacked archive [bytes]."""
DAMAGED = (
    zipfile.BadZipFile, zlib.error, EOFError, KeyError, NotImplementedError, OSError, RuntimeError, ValueError,
)  # fmt: skip
"""Errors that Python raises for a damaged archive, or for damaged JSON in one."""
NAMES = """
    NumToTensor RaiseException __and__ __contains__ __getitem__ __is__ __isnot__ __not__ __or__ _convolution abs
    adaptive_avg_pool1d add add_ addmm all annotate any append arange argmax atan atan2 avg_pool1d baddbmm
    batch_norm bmm cat ceil celu celu_ chunk clamp clamp_ contiguous conv1d conv2d cos cpu data detach device
    dim div div_ dropout dropout_ dtype einsum elu elu_ embedding eq equal exp expand flatten floor floordiv
    format full gather ge gelu greater group_norm gru gru_cell gt hardsigmoid hardswish hardswish_ hardtanh
    hardtanh_ index_select item layer_norm layout le leaky_relu leaky_relu_ len linear list log log_softmax
    logical_and logical_not logical_or lstm lstm_cell lt masked_fill masked_fill_ matmul max max_pool1d maximum
    mean min minimum mish mish_ mm mode mul mul_ name narrow ne neg negative norm numel ones ones_like pad
    permute pin_memory positive pow prelu range reciprocal relu relu6 relu_ remainder repeat reshape rms_norm
    round rsqrt scaled_dot_product_attention select selu selu_ sigmoid sign silu silu_ sin size slice softmax
    softplus split sqrt square squeeze stack std str stride sub sub_ sum t tanh tanh_ tensor threshold to
    transpose type unchecked_cast unflatten unsqueeze var view view_as warn where zeros zeros_like
"""
PLAIN = frozenset(re.findall(r"\w+", NAMES))
"""Operations of TorchScript that networks consist of. They only compute."""
SPELLED = re.compile(rb'\\|\bgetattr\b(?!\(\w+, "\w+"\))|\bclasses\b|\bops\b(?!\.(?:aten|prim)\.)')
"""Text that could do more: escapes, ``getattr`` of anything but a name, classes and operations of C++ libraries."""


class TorchDriver:
    """Runs the module on the CPU."""

    def __init__(self, module: Any) -> None:
        self._module = module

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Return the module's output."""
        torch = import_module("torch")
        with torch.inference_mode():
            return self._module(torch.from_numpy(observation)).numpy()


def load(path: Path, *, trust: bool) -> tuple[TorchDriver, str]:
    """Return the driver and its observation set.

    Raises DriverError if the file isn't such a module, or needs ``trust`` and doesn't have it.
    """
    kind = _kind(path)
    if kind != "TorchScript" and not trust:
        raise DriverError(f"{path}: {kind}, which can run any code while it is loaded; {WAY_OUT}")
    torch = import_torch(path)
    if kind == "TorchScript" and not trust:
        _check_operations(torch, path)
    extra: dict[str, Any] = {OBSERVES: ""}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # torch.jit.load warns, but such files exist
            module = _module(torch, path, kind, extra)
    except DriverError:
        raise
    except Exception as error:  # PyTorch raises anything for a damaged archive
        what = str(error).strip().split("\n")[0]
        raise DriverError(f"{path}: can't be loaded as {kind} ({what}); save it again") from error
    named = extra[OBSERVES]
    observes = named.decode(errors="replace") if isinstance(named, bytes) else named
    features = _features(module)
    if features is None:
        raise DriverError(f"{path}: has no weights to tell how many numbers it takes; wrap it in a Python driver")
    return TorchDriver(module), set_of_size(path, features, observes or None)


def import_torch(path: Path) -> Any:
    """Import PyTorch. Raises DriverError if it isn't installed."""
    try:
        return import_module("torch")
    except ImportError as error:
        raise DriverError(f"{path}: needs PyTorch: pip install 'jaxwalk[torch]'") from error


def check_unpacked(path: Path, archive: zipfile.ZipFile) -> None:
    """Raise DriverError if an archive is too large to unpack into memory."""
    size = sum(entry.file_size for entry in archive.infolist())
    if size > MOST_BYTES:
        raise DriverError(f"{path}: unpacked it has {size:,} bytes; a driver has at most {MOST_BYTES:,}")


def _check_operations(torch: Any, path: Path) -> None:
    """Raise DriverError if TorchScript does more than compute. Reads it as PyTorch does, but without loading it.

    Code can call an operation only by its name, so every word that is an operation's name must be PLAIN. PyTorch
    ignores the case of the records' names.
    """
    try:
        reader = torch._C.PyTorchFileReader(str(path))
        records = [(name.lower(), reader.get_record(name)) for name in reader.get_all_records()]
    except (RuntimeError, UnicodeDecodeError) as error:  # the latter for names of records
        what = str(error).strip().split("\n")[0]
        raise DriverError(f"{path}: can't be loaded as TorchScript ({what}); save it again") from error
    if any(name == "model.json" for name, _ in records):  # the first versions', which could keep code anywhere
        raise DriverError(f"{path}: an old TorchScript file, whose code can't be checked; {WAY_OUT}")
    operations = {schema.name.rpartition("::")[2] for schema in torch._C._jit_get_all_schemas()}
    for name, content in records:
        is_code = name.startswith("code/") and not name.endswith(".debug_pkl")
        found = _beyond_computing(content, operations) if is_code else ""
        if name.endswith(".pkl") and b"classes" in content:
            found = "classes"
        if found:
            raise DriverError(f"{path}: its TorchScript uses {found}, which may do more than compute; {WAY_OUT}")


def _beyond_computing(script: bytes, operations: set[str]) -> str:
    """Return a word of a script that may do more than compute, or an empty string if there is none."""
    spelled = SPELLED.search(script)
    words = {word.decode() for word in re.findall(rb"\w+", script)}
    return spelled[0].decode() if spelled else min(words & operations - PLAIN, default="")


def _kind(path: Path) -> str:
    """Return what an archive is, by the names inside, without loading any of it."""
    if not zipfile.is_zipfile(path):
        return "an old PyTorch file of pickled objects"
    try:
        with zipfile.ZipFile(path) as archive:
            check_unpacked(path, archive)
            inside = {name.partition("/")[2] for name in archive.namelist()}
    except DAMAGED as error:
        raise DriverError(f"{path}: damaged ({error}); save it again") from error
    if "constants.pkl" in inside and any(name.startswith("code/") for name in inside):
        return "TorchScript"
    if "archive_format" in inside and any(name.startswith("models/") for name in inside):
        return "a torch.export archive"
    return "a PyTorch file of pickled objects"


def _module(torch: Any, path: Path, kind: str, extra: dict[str, Any]) -> Any:
    """Return the module, ready to be called. Fills ``extra`` with the texts that were saved with it."""
    if kind == "TorchScript":
        return torch.jit.load(str(path), map_location="cpu", _extra_files=extra).eval()
    if kind == "a torch.export archive":
        return torch.export.load(str(path), extra_files=extra).module()
    loaded = torch.load(path, map_location="cpu", weights_only=False)
    if not isinstance(loaded, torch.nn.Module):
        raise DriverError(f"{path}: holds weights without a network ({type(loaded).__name__}); save it as TorchScript")
    return loaded.eval()


def _features(module: Any) -> int | None:
    """Return the number of inputs: the width of the first weight matrix, or None if there is none."""
    return next((int(x.shape[1]) for x in module.parameters() if x.ndim == 2), None)

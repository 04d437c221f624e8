"""A driver in a PyTorch file: a module that takes ``(episodes, features)`` and returns the action ``(episodes, 2)``.

TorchScript is loaded by PyTorch's own reader, which knows tensors and TorchScript operations only and unpickles no
Python objects. Some operations reach beyond the network, such as ``torch.save``, and loading already runs some code
(defaults of arguments), so the code is read before: whatever isn't plainly of a network takes ``trust``. Everything
else (`torch.export`, whole modules by `torch.save`) may run any Python code while it is
loaded: `torch.export.load` unpickles some weights, and evaluates expressions for the shapes. That takes ``trust``.
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
from jaxwalk.policies.host.load import set_of_size

OBSERVES = "observes"
"""The extra file of an archive that names the observation set (``_extra_files``, ``extra_files``)."""
WAY_OUT = "give it as ONNX or plain TorchScript instead, or say --trust if you know where it comes from"

MOST_BYTES = 2**30
"""An archive holds no more when it is unpacked."""
DAMAGED = (
    zipfile.BadZipFile, zlib.error, EOFError, KeyError, NotImplementedError, OSError, RuntimeError, ValueError,
)  # fmt: skip
"""What a damaged archive, or JSON in one, makes Python raise."""
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
"""Operations of TorchScript that networks are made of. They only compute."""
SPELLED = re.compile(rb'\\|\bgetattr\b(?!\(\w+, "\w+"\))|\bclasses\b|\bops\b(?!\.(?:aten|prim)\.)')
"""What could reach further: escapes, ``getattr`` of anything but a name, classes and operations of C++ libraries."""


class TorchDriver:
    """Runs the module on the processor."""

    def __init__(self, module: Any) -> None:
        self._module = module

    def act(self, observation: np.ndarray) -> np.ndarray:
        """What the module returns."""
        torch = import_module("torch")
        with torch.inference_mode():
            return self._module(torch.from_numpy(observation)).numpy()


def load(path: Path, *, trust: bool) -> tuple[TorchDriver, str]:
    """The driver and its observation set.

    Raises DriverError for a file that is no such module, or that needs ``trust`` and has it not.
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
            warnings.simplefilter("ignore", DeprecationWarning)  # of torch.jit.load: people have such files
            module = _module(torch, path, kind, extra)
    except DriverError:
        raise
    except Exception as error:  # (whatever a damaged archive makes PyTorch raise)
        what = str(error).strip().split("\n")[0]
        raise DriverError(f"{path}: can't be loaded as {kind} ({what}); save it again") from error
    named = extra[OBSERVES]
    observes = named.decode(errors="replace") if isinstance(named, bytes) else named
    features = _features(module)
    if features is None:
        raise DriverError(f"{path}: has no weights to tell how many numbers it takes; wrap it in a Python driver")
    return TorchDriver(module), set_of_size(path, features, observes or None)


def import_torch(path: Path) -> Any:
    """PyTorch; raises DriverError if it isn't installed."""
    try:
        return import_module("torch")
    except ImportError as error:
        raise DriverError(f"{path}: needs PyTorch: pip install 'jaxwalk[torch]'") from error


def check_unpacked(path: Path, archive: zipfile.ZipFile) -> None:
    """Raise DriverError for an archive that would fill memory."""
    size = sum(entry.file_size for entry in archive.infolist())
    if size > MOST_BYTES:
        raise DriverError(f"{path}: unpacked it has {size:,} bytes; a driver has at most {MOST_BYTES:,}")


def _check_operations(torch: Any, path: Path) -> None:
    """Raise DriverError for TorchScript that does more than compute; read as PyTorch reads it, before it is loaded.

    An operation can be called by its name only, so every word that is the name of one must be PLAIN. PyTorch finds
    records whatever the case of their names.
    """
    try:
        reader = torch._C.PyTorchFileReader(str(path))
        records = [(name.lower(), reader.get_record(name)) for name in reader.get_all_records()]
    except (RuntimeError, UnicodeDecodeError) as error:  # (the latter for names of records)
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
    """Something in a script that isn't plainly of a network; empty if there is nothing."""
    spelled = SPELLED.search(script)
    words = {word.decode() for word in re.findall(rb"\w+", script)}
    return spelled[0].decode() if spelled else min(words & operations - PLAIN, default="")


def _kind(path: Path) -> str:
    """What the archive is, by the names in it, without loading any of it."""
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
    """The module, ready to be called; ``extra`` gets the texts that were saved with it."""
    if kind == "TorchScript":
        return torch.jit.load(str(path), map_location="cpu", _extra_files=extra).eval()
    if kind == "a torch.export archive":
        return torch.export.load(str(path), extra_files=extra).module()
    loaded = torch.load(path, map_location="cpu", weights_only=False)
    if not isinstance(loaded, torch.nn.Module):
        raise DriverError(f"{path}: holds weights without a network ({type(loaded).__name__}); save it as TorchScript")
    return loaded.eval()


def _features(module: Any) -> int | None:
    """How many numbers it takes: the width of its first weight matrix; None if it has none."""
    return next((int(x.shape[1]) for x in module.parameters() if x.ndim == 2), None)

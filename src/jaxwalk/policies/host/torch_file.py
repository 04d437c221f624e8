"""A driver in a PyTorch file: a module that takes ``(episodes, features)`` and returns the action ``(episodes, 2)``.

TorchScript is loaded by PyTorch's own reader, which knows tensors and TorchScript operations only and unpickles no
Python objects; a few of its operations reach beyond the network, such as ``torch.save``, and take ``trust``. Everything
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
BEYOND_COMPUTING = re.compile(rb"\b(?:from_file|save|load_tensor|rpc_\w+|\w*PythonOp)\b|\bops\.(?!aten\b|prim\b)\w+")
"""Operations of TorchScript that reach beyond the network: files, other machines, Python, libraries of others."""


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
    observes = extra[OBSERVES].decode() if isinstance(extra[OBSERVES], bytes) else extra[OBSERVES]
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
    """Raise DriverError for TorchScript that does more than compute; read as PyTorch reads it, before it is loaded."""
    try:
        reader = torch._C.PyTorchFileReader(str(path))
        scripts = [reader.get_record(name) for name in reader.get_all_records() if name.endswith(".py")]
    except RuntimeError as error:
        what = str(error).strip().split("\n")[0]
        raise DriverError(f"{path}: can't be loaded as TorchScript ({what}); save it again") from error
    for script in scripts:
        found = BEYOND_COMPUTING.search(script)
        if found:
            called = found[0].decode()
            raise DriverError(
                f"{path}: its TorchScript calls {called}, which can touch files or other machines; {WAY_OUT}"
            )


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

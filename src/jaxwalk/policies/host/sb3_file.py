"""A Stable-Baselines3 agent, as ``model.save("ppo.zip")`` writes it. Its actions are deterministic and clipped.

PPO and A2C agents with an ``MlpPolicy`` are rebuilt from their weights alone: nothing is unpickled. All other agents
are pickled objects and need ``trust``. Observations must be a flat set, as the Gymnasium adapter returns them; the
network's input size tells the set.
"""

from __future__ import annotations

import io
import json
import pickletools
import re
import zipfile
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.policies.host.driver import DriverError
from jaxwalk.policies.host.loaders import set_of_size
from jaxwalk.policies.host.torch_file import DAMAGED, check_unpacked, import_torch

ACTIVATIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "torch.nn.modules.activation.Tanh": np.tanh,
    "torch.nn.modules.activation.ReLU": lambda x: np.maximum(x, 0),
}
"""Activation functions between layers, by the class that the agent's file names."""
TANH = "torch.nn.modules.activation.Tanh"
"""Default activation function of Stable-Baselines3 for PPO and A2C."""
HARMLESS = {"activation_fn", "net_arch", "log_std_init", "ortho_init", "optimizer_class", "optimizer_kwargs"}
"""Supported ``policy_kwargs``: they don't change the action, or the weights show their value."""
LAYER = re.compile(r"mlp_extractor\.policy_net\.(\d{1,3})\.weight")
NOT_THE_ACTOR = ("mlp_extractor.value_net.", "value_net.", "log_std")

CONSTRUCTORS = {
    "collections OrderedDict", "torch FloatStorage", "torch._utils _rebuild_tensor_v2",
    "torch._utils _rebuild_parameter",
}  # fmt: skip
"""The only functions that weights may call while PyTorch reads them."""
ARCHIVE = b"PK\x03\x04"
"""First bytes of PyTorch's archives. PyTorch reads other files as a stream of pickles, an older format."""

Layers = list[tuple[np.ndarray, np.ndarray]]


class _OtherAgentError(Exception):
    """An agent can't be rebuilt from its weights; the message is the reason."""


class MlpDriver:
    """Fully connected layers, with outputs clipped as Stable-Baselines3 clips them."""

    def __init__(self, layers: Layers, activation: Callable[[np.ndarray], np.ndarray]) -> None:
        self._layers, self._activation = layers, activation

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Return the mean action, clipped to [-1, 1]."""
        *hidden, (weight, bias) = self._layers
        for hidden_weight, hidden_bias in hidden:
            observation = self._activation(observation @ hidden_weight.T + hidden_bias)
        return np.clip(observation @ weight.T + bias, -1, 1)


class Sb3Driver:
    """A policy object of Stable-Baselines3."""

    def __init__(self, policy: Any) -> None:
        self._policy = policy

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Return the deterministic action, clipped to [-1, 1]."""
        action, _ = self._policy.predict(observation, deterministic=True)
        return np.clip(action, -1, 1)


def load(path: Path, *, trust: bool) -> tuple[MlpDriver | Sb3Driver, str]:
    """Return the driver and its observation set.

    Raises DriverError if the file isn't such an agent, or needs ``trust`` and doesn't have it.
    """
    data = _data(path)
    _check_actions(path, data)
    torch = import_torch(path)
    try:
        layers, activation = _layers(torch, path), ACTIVATIONS[_activation(data)]
    except _OtherAgentError as reason:
        if trust:
            return _unpickled(path)
        raise DriverError(
            f"{path}: {reason}, so it can't be loaded without unpickling, which can run any code; export it to "
            "ONNX, or say --trust if you know where it comes from"
        ) from reason
    return MlpDriver(layers, activation), set_of_size(path, layers[0][0].shape[1])


def _data(path: Path) -> dict[str, Any]:
    """Return the agent's description: JSON, in which pickled objects are text that is never unpickled."""
    try:
        data = _checked_data(path)
    except DriverError:
        raise
    except DAMAGED as error:
        raise DriverError(f"{path}: damaged or no Stable-Baselines3 agent ({error}); save it again") from error
    if not isinstance(data, dict):
        raise DriverError(f"{path}: damaged or no Stable-Baselines3 agent (data is no object); save it again")
    return data


def _checked_data(path: Path) -> Any:
    """Return the entry ``data`` as JSON, after checking the sizes of the archive and of the weights inside it."""
    with zipfile.ZipFile(path) as archive:
        check_unpacked(path, archive)
        data = json.loads(archive.read("data"))
        with archive.open("policy.pth") as file, zipfile.ZipFile(file) as weights:
            check_unpacked(path, weights)
    return data


def _part(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return an object inside the description, or an empty one if the name is missing."""
    found = data.get(name)
    return found if isinstance(found, dict) else {}


def _activation(data: Mapping[str, Any]) -> str:
    """Return the name of the activation class, from the text beside the pickled class."""
    options = {name: x for name, x in _part(data, "policy_kwargs").items() if not name.startswith(":")}
    unknown = ", ".join(sorted(options.keys() - HARMLESS))
    if unknown:
        raise _OtherAgentError(f"its policy was made with {unknown}")
    found = re.fullmatch(r"<class '(.+)'>", str(options.get("activation_fn", f"<class '{TANH}'>")))
    if not found or found[1] not in ACTIVATIONS:
        raise _OtherAgentError(f"its activation function is {options['activation_fn']}")
    return found[1]


def _layers(torch: Any, path: Path) -> Layers:
    """Return the actor's layers, first to last. Raises _OtherAgentError if it has others."""
    with zipfile.ZipFile(path) as archive:
        content = archive.read("policy.pth")
    try:
        _check_constructors(torch, content)
        weights = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except _OtherAgentError:
        raise
    except Exception as error:  # pickle.UnpicklingError for other objects than tensors, others for a damaged file
        raise _OtherAgentError("its weights hold more than tensors, or are damaged") from error
    if not isinstance(weights, dict) or not all(_is_matrix(torch, name, x) for name, x in weights.items()):
        raise _OtherAgentError("its weights hold more than matrices and vectors by name")
    numbers = sorted(int(found[1]) for name in weights if (found := LAYER.fullmatch(name)))
    names = [*(f"mlp_extractor.policy_net.{i}" for i in numbers), "action_net"]
    wanted = {f"{name}.{kind}" for name in names for kind in ("weight", "bias")}
    others = {name for name in weights.keys() - wanted if not name.startswith(NOT_THE_ACTOR)}
    missing = wanted - weights.keys()
    if others or missing:
        raise _OtherAgentError(f"it is no PPO or A2C MlpPolicy ({', '.join(sorted(others | missing)[:3])})")
    return [(weights[f"{name}.weight"].numpy(), weights[f"{name}.bias"].numpy()) for name in names]


def _check_constructors(torch: Any, content: bytes) -> None:
    """Raise _OtherAgentError if weights call anything but CONSTRUCTORS: PyTorch would allow a bytearray of any size."""
    if not content.startswith(ARCHIVE):
        raise _OtherAgentError("its weights are in an old format")
    pickled = torch._C.PyTorchFileReader(io.BytesIO(content)).get_record("data.pkl")
    called = {str(argument) for code, argument, _ in pickletools.genops(pickled) if code.name in ("GLOBAL", "INST")}
    if others := called - CONSTRUCTORS:
        raise _OtherAgentError(f"its weights call {min(others)}")


def _is_matrix(torch: Any, name: Any, x: Any) -> bool:
    """Return whether x is a named float32 matrix or vector, stored in full: a view could repeat numbers without end."""
    plain = isinstance(name, str) and isinstance(x, torch.Tensor) and x.dtype == torch.float32
    return plain and x.is_contiguous() and x.ndim == (2 if name.endswith("weight") else 1)


def _unpickled(path: Path) -> tuple[Sb3Driver, str]:
    """Load any agent by Stable-Baselines3, which runs pickled code. Raises DriverError if that fails."""
    try:
        policies = import_module("stable_baselines3.common.policies")
        saving = import_module("stable_baselines3.common.save_util")
    except ImportError as error:
        raise DriverError(f"{path}: needs Stable-Baselines3: pip install 'jaxwalk[frameworks]'") from error
    try:
        loaded: Any = saving.load_from_zip_file(str(path), device="cpu")
        data, weights, _ = loaded
        options = dict(data["policy_kwargs"])
        if issubclass(data["policy_class"], policies.ActorCriticPolicy):
            options["use_sde"] = data["use_sde"]
        spaces = data["observation_space"], data["action_space"]
        policy = data["policy_class"](*spaces, lambda _: 0.0, **options)
        policy.load_state_dict(weights["policy"])
    except Exception as error:  # the agent's own classes may raise anything
        raise DriverError(f"{path}: Stable-Baselines3 can't load it ({error}); save it with this version") from error
    if len(spaces[0].shape or ()) != 1:
        raise DriverError(f"{path}: observes {spaces[0]}, not one flat box; train it on the Gymnasium adapter")
    return Sb3Driver(policy.eval()), set_of_size(path, spaces[0].shape[0])


def _check_actions(path: Path, data: Mapping[str, Any]) -> None:
    """Raise DriverError unless actions are two numbers in [-1, 1], by the text beside the pickled space."""
    space = _part(data, "action_space")
    bounds = str(space.get("low")), str(space.get("high"))
    if bounds != ("[-1. -1.]", "[1. 1.]"):
        raise DriverError(
            f"{path}: its actions lie between {bounds[0]} and {bounds[1]}, not [-1. -1.] and [1. 1.]; "
            "train it on the Gymnasium adapter"
        )

"""Trained networks as policies, and their files.

A file is safetensors: named arrays and a text header, no code. It holds the actor of each role that was trained. The
header's entry ``jaxwalk`` is JSON: how to rebuild the actors, and where they come from.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Literal

import equinox as eqx
import jax
import numpy as np
import pydantic
import safetensors
import safetensors.numpy
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import View
from jaxwalk.learning.actor import DISCRETE, GATED, Actor, Held, decide
from jaxwalk.learning.mappo import Learner
from jaxwalk.learning.networks import MLP
from jaxwalk.sim.observation import Observation
from jaxwalk.writing import write_whole

FORMAT: Final = 1
"""Version of the file format."""
HEADER = "jaxwalk"
"""The header's entry that jaxwalk writes and reads."""


class PolicyError(ValueError):
    """A policy file can't be used. The message names the file, says what is wrong and what to do, in one line."""


@dataclass(frozen=True)
class RoleHeader:
    """How to rebuild the actor of one role."""

    observes: str
    """Name of the observation set that it reads."""
    kind: Literal["discrete", "gated", "clipped", "tanh"]
    """Meaning of the network's outputs: `Actor.kind`."""
    sizes: tuple[int, ...]
    """Number of inputs, units of each hidden layer, outputs."""
    hold: int = 1
    """Steps for which a gated policy holds a decision."""


@dataclass(frozen=True)
class Header:
    """What a file says about its content."""

    format: int
    """Version of the file format."""
    roles: dict[str, RoleHeader]
    """The actors in it."""
    metadata: dict[str, Any]
    """Where the actors come from, as given to `save_policy`."""


class LearnedPolicy(eqx.Module):
    """A trained actor, which decides for all agents of its role."""

    actor: Actor
    """The network and its distribution."""
    role: str = eqx.field(static=True)
    """The role it plays."""
    sample: bool = eqx.field(static=True, default=False)
    """Whether to draw the action at random, as in training, instead of taking the most likely one."""

    @property
    def view(self) -> View:
        """What it sees: the observation set of its network's header."""
        return Observation(self.role, self.actor.observes)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Held | None:
        """Return a memory without a decision, or None for a policy that decides at every step."""
        return self.actor.init(agents, batch)

    def act(
        self, key: Key[Array, "*batch"], memory: Held | None, observation: Float[Array, "feature ..."]
    ) -> tuple[Array, Held | None]:
        """Return the action of every agent, and the next memory."""
        choice, memory = decide(self.actor, key, memory, observation, sample=self.sample, checked=True)
        return choice.action, memory


def save_policy(path: str | Path, actors: Learner | Mapping[str, Actor], metadata: Mapping[str, Any]) -> None:
    """Write the actors by role, with any JSON ``metadata`` (recipe, seed, commit, steps, results, ...).

    The file appears whole or not at all.
    """
    actors = actors.actors if isinstance(actors, Learner) else actors
    arrays = {f"{role}.{name}": x for role, actor in actors.items() for name, x in _arrays(actor).items()}
    roles = {role: RoleHeader(x.observes, x.kind, x.network.sizes, x.hold) for role, x in actors.items()}  # pyright: ignore
    header = json.dumps(asdict(Header(FORMAT, roles, dict(metadata))), sort_keys=True, allow_nan=False)
    write_whole(path, safetensors.numpy.save(arrays, {HEADER: header}))


def load_policy(path: str | Path, role: str, *, sample: bool = False, expect_size: int | None = None) -> LearnedPolicy:
    """Return the policy of a role from a file.

    Raises PolicyError if the file can't be used, has no such role, or doesn't read ``expect_size`` numbers (if given).
    """
    header, arrays = _read(path)
    if role not in header.roles:
        held = ", ".join(sorted(header.roles)) or "none"
        raise PolicyError(f"{path}: holds no {role} policy (it has: {held}); choose a file in which the {role} learned")
    own = {name.removeprefix(f"{role}."): x for name, x in arrays.items() if name.startswith(f"{role}.")}
    actor = _actor(path, header.roles[role], own)
    size = actor.network.sizes[0]
    if expect_size is not None and size != expect_size:
        raise PolicyError(
            f"{path}: the {role} reads {size} numbers ({actor.observes!r}), but the environment gives {expect_size}; "
            "use the environment configuration that it was trained with, or train again"
        )
    return LearnedPolicy(actor, role, sample)


def read_metadata(path: str | Path) -> dict[str, Any]:
    """Return the ``metadata`` of a file as saved, and under ``roles`` a description of each network.

    Raises PolicyError if the file can't be used.
    """
    header, _ = _read(path)
    return header.metadata | {"roles": {role: asdict(described) for role, described in header.roles.items()}}


def _arrays(actor: Actor) -> dict[str, np.ndarray]:
    layers = zip(actor.network.weights, actor.network.biases, strict=True)
    named = {}
    for i, (weight, bias) in enumerate(layers):
        named |= {f"layer{i}.weight": weight, f"layer{i}.bias": bias}
    if actor.log_std is not None:
        named["log_std"] = actor.log_std
    return {name: np.asarray(x) for name, x in named.items()}


def _read(path: str | Path) -> tuple[Header, dict[str, np.ndarray]]:
    """Return the header and all arrays, or raise PolicyError."""
    if not Path(path).is_file():
        raise PolicyError(f"{path}: no such file; check the name, or train and save a policy first")
    try:
        with safetensors.safe_open(str(path), framework="numpy") as file:
            text = (file.metadata() or {}).get(HEADER)
            names = file.keys()
            arrays = {name: file.get_tensor(name) for name in names}
    except (
        safetensors.SafetensorError,
        OSError,
        TypeError,
        AttributeError,
    ) as error:  # the last two for dtypes NumPy lacks
        raise PolicyError(f"{path}: damaged or no safetensors file ({error}); copy or download it again") from error
    if text is None:
        raise PolicyError(f"{path}: a safetensors file, but not of jaxwalk; give a file written by save_policy")
    return _header(path, text), arrays


def _header(path: str | Path, text: str) -> Header:
    """Return the checked header. The format comes first, because another format may have other fields."""
    try:
        header = pydantic.TypeAdapter(dict[str, Any]).validate_json(text)
        version = header.get("format")
        if version != FORMAT:
            raise PolicyError(f"{path}: has format {version}, this jaxwalk reads {FORMAT}; use a version that reads it")
        return pydantic.TypeAdapter(Header).validate_python(header)
    except pydantic.ValidationError as error:
        where = ".".join(str(part) for part in error.errors()[0]["loc"])
        fault = error.errors()[0]["msg"]
        raise PolicyError(f"{path}: its header is wrong ({where}: {fault}); copy or download it again") from error


def _actor(path: str | Path, described: RoleHeader, arrays: dict[str, np.ndarray]) -> Actor:
    """Rebuild an actor. Raise PolicyError unless every array is there, has its shape and holds finite numbers."""
    sizes, kind = described.sizes, described.kind
    layers = range(len(sizes) - 1)
    if described.hold < 1:
        raise PolicyError(f"{path}: its header is wrong (hold: {described.hold}); copy or download it again")
    if len(sizes) < 2 or min(sizes) < 1:
        raise PolicyError(f"{path}: its header is wrong (sizes: {list(sizes)}); copy or download it again")
    wanted = {f"layer{i}.weight": (sizes[i + 1], sizes[i]) for i in layers}
    wanted |= {f"layer{i}.bias": (sizes[i + 1],) for i in layers}
    if kind not in (DISCRETE, GATED):
        wanted["log_std"] = (sizes[-1],)
    found = {name: x.shape for name, x in arrays.items()}
    if found != wanted:
        wrong = ", ".join(sorted(n for n in wanted.keys() | found.keys() if wanted.get(n) != found.get(n)))
        raise PolicyError(f"{path}: its arrays don't match its header ({wrong}); copy or download it again")
    for name, x in arrays.items():
        if x.dtype != np.float32 or not np.isfinite(x).all():
            raise PolicyError(f"{path}: {name} holds something else than finite float32 numbers; train again")
    loaded = jax.device_put(arrays)
    network = MLP(tuple(loaded[f"layer{i}.weight"] for i in layers), tuple(loaded[f"layer{i}.bias"] for i in layers))
    return Actor(network, loaded.get("log_std"), observes=described.observes, kind=kind, hold=described.hold)

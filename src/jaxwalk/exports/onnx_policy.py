"""A trained policy as an ONNX file, written only if it acts as the policy does."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Key

from jaxwalk.acting import Player, act, cast_of, fresh_memory
from jaxwalk.interfaces import Policy
from jaxwalk.learning.actor import Held
from jaxwalk.policies import AlwaysGo, PolicyError, RouteFollower, read_metadata
from jaxwalk.policies.learned import LearnedPolicy
from jaxwalk.policies.onnx_export import onnx_model
from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start
from jaxwalk.runs.contestants import contestant, policy_file, world_of
from jaxwalk.sim.environment import Street
from jaxwalk.writing import write_whole

LARGEST_GAP = 1e-4
"""A file is written only if no action, or logit, differs by more."""
ENVIRONMENTS, STEPS = 64, 256
"""How much is played to compare on: all that the policy meets there."""


class Met(eqx.Module):
    """What a policy met and did: arrays ``(..., row)``."""

    observation: Array | np.ndarray
    memory: Held | None
    """Before it acted."""
    action: Array | np.ndarray
    outputs: Array | np.ndarray
    """Of its network."""


@dataclass(frozen=True)
class Parity:
    """How well a file agrees with its policy."""

    rows: int
    """Observations compared."""
    gap: float
    """Largest difference of an action of a driver; of pedestrians, of a logit."""
    other_choices: int
    """Pedestrians' actions that differ although logits are further apart than rounding explains."""

    @property
    def passes(self) -> bool:
        """Whether the file may be written."""
        return self.gap <= LARGEST_GAP and not self.other_choices


def export(name: str, out: Path, *, role: str) -> Parity:
    """Write the policy of a run folder, a policy file or a shipped name as ONNX.

    Raises PolicyError if onnx or ONNX Runtime is missing, or the network in ONNX acts otherwise than the policy.
    """
    street = world_of([name], ())
    policy = contestant(street, role, name, sample=False)
    if not isinstance(policy, LearnedPolicy):
        raise PolicyError(f"{name}: is a rule, not a trained policy; name a run folder, a policy file or a shipped one")
    file = policy_file(role, name)
    content = onnx_model(policy.actor, role=role, metadata=_origin(file, street))
    parity = check_parity(content, policy, met(street, role, policy))
    if not parity.passes:
        raise PolicyError(
            f"{name}: in ONNX it acts otherwise (largest gap {parity.gap:.1e}, {parity.other_choices} other choices of "
            f"{parity.rows:,}), so {out} was not written; another version of onnxruntime may help"
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    write_whole(out, content)
    return parity


def _origin(file: Path, street: Street) -> dict[str, str]:
    """Where the network comes from, for its metadata."""
    about = read_metadata(file)
    told = {name: str(about[name]) for name in ("recipe", "seed", "steps", "commit") if name in about}
    made = {
        "version": version("jaxwalk"),
        "policy_sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
        "config_sha256": hashlib.sha256(json.dumps(asdict(street.config), sort_keys=True).encode()).hexdigest(),
    }
    return {f"jaxwalk.{name}": value for name, value in {**made, **told}.items()}


def met(street: Street, role: str, policy: LearnedPolicy) -> Met:
    """What the policy meets in scenarios of a training seed, beside people who always go or a route-follower."""
    policies: dict[str, Policy] = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    policies[role] = policy
    cast = cast_of(policies) | {role: (Player(policy, policy.view, decide=_meet),)}

    def act_and_record(key: Key[Array, "env"], scenario: Any, state: Any, memory: Any) -> tuple[Any, Any, Met]:
        acted = act(street, cast, key, scenario, state, memory)
        return acted.actions, acted.memory, acted.records[role][0]

    @eqx.filter_jit
    def played(street: Street) -> Met:
        memory = fresh_memory(street, cast, (ENVIRONMENTS,))
        stream = start(street, environment_keys(seed_key(0, TRAINING), 0, ENVIRONMENTS), memory)
        return rollout(street, act_and_record, stream, STEPS, fresh_memory=memory, keep=lambda step: step.record)[1]

    found = played(street)
    agents = len(street.roles[role].agents)
    return jax.tree.map(lambda x: _rows(x, axes=agents + 1), found)


def _meet(policy: LearnedPolicy, key: Key[Array, "env"], memory: Held | None, seen: Array) -> tuple[Array, Any, Met]:
    """Let the policy act, and record everything about it."""
    action, after = policy.act(key, memory, seen)
    return action, after, Met(seen, memory, action, policy.actor.network(seen))


def _rows(x: Array, *, axes: int) -> np.ndarray:
    """``(time, *features, *agents, env)`` as ``(*features, row)``; ``axes``: how many agent and env axes there are."""
    kept = np.moveaxis(np.asarray(x), 0, -1)
    return kept.reshape(*kept.shape[: kept.ndim - axes - 1], -1)


def check_parity(content: bytes, policy: LearnedPolicy, met: Met) -> Parity:
    """How the network in an ONNX file compares with the policy on all that it met."""
    try:
        session = import_module("onnxruntime").InferenceSession(content, providers=["CPUExecutionProvider"])
    except ImportError as error:
        raise PolicyError("to check ONNX needs ONNX Runtime: pip install 'jaxwalk[onnx]'") from error
    memory = {} if met.memory is None else {"choice": met.memory.choice, "left": met.memory.left}
    given = {"observation": np.ascontiguousarray(met.observation.T), **memory}
    names = [output.name for output in session.get_outputs()]
    found = dict(zip(names, session.run(None, given), strict=True))
    rows = met.observation.shape[1]
    if "logits" not in found:
        return Parity(rows, float(np.abs(found["action"].T - met.action).max()), 0)
    margin = np.abs(met.outputs[1] - met.outputs[0])
    other = (found["action"] != met.action) & (margin > LARGEST_GAP)
    return Parity(rows, float(np.abs(found["logits"].T - met.outputs).max()), int(other.sum()))

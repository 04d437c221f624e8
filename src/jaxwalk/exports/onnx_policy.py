"""A trained policy as an ONNX file, which is written only if it acts as the policy does."""

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
from jaxwalk.evaluation.broken import ADVICE
from jaxwalk.exports.onnx_model import onnx_model
from jaxwalk.interfaces import Policy
from jaxwalk.learning.actor import Held
from jaxwalk.policies import AlwaysGo, PolicyError, RouteFollower, read_metadata
from jaxwalk.policies.learned import LearnedPolicy
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start
from jaxwalk.runs.contestant_names import policy_file
from jaxwalk.runs.contestants import named_policy, world_of
from jaxwalk.sim.environment import Street
from jaxwalk.writing import write_whole

LARGEST_GAP = 1e-4
"""Largest difference of an action or a logit with which a file is still written."""
ENVIRONMENTS, STEPS = 64, 256
"""Number of environments and of steps in which file and policy are compared."""


class Met(eqx.Module):
    """What a policy observed and did: arrays ``(..., row)``."""

    observation: Array | np.ndarray
    memory: Held | None
    """The memory before it acted."""
    action: Array | np.ndarray
    outputs: Array | np.ndarray
    """The outputs of its network."""


@dataclass(frozen=True)
class Parity:
    """How well a file agrees with its policy."""

    rows: int
    """Number of observations compared."""
    gap: float
    """Largest difference of a driver's action, or of a pedestrian's logit."""
    other_choices: int
    """Number of pedestrians' actions that differ although the logits are further apart than rounding explains."""

    @property
    def passes(self) -> bool:
        """Return whether the file may be written."""
        return self.gap <= LARGEST_GAP and not self.other_choices


def export(name: str, out: Path, *, role: str) -> Parity:
    """Write the policy of a run folder, a policy file or a shipped name as ONNX.

    Raises PolicyError if onnx or ONNX Runtime is missing, an action isn't in its space, or the network in ONNX acts
    differently from the policy.
    """
    bare, shield = unshielded(role, name)
    if shield is not None:
        raise PolicyError(f"{name}: a shield is no network; export {bare}, and shield what was exported")
    street = world_of([name])
    policy = named_policy(street, role, name, sample=False)
    if not isinstance(policy, LearnedPolicy):
        raise PolicyError(f"{name}: is a rule, not a trained policy; name a run folder, a policy file or a shipped one")
    file = policy_file(role, name)
    content = onnx_model(policy.actor, role=role, metadata=_origin(file, street))
    space, found = street.roles[role].action, met(street, role, policy)
    if not space.contains(found.action).all():
        raise PolicyError(f"{name}: an action isn't {space}; {ADVICE}")
    parity = check_parity(content, policy, found)
    if not parity.passes:
        raise PolicyError(
            f"{name}: in ONNX it acts otherwise (largest gap {parity.gap:.1e}, {parity.other_choices} other choices of "
            f"{parity.rows:,}), so {out} was not written; another version of onnxruntime may help"
        )
    out.parent.mkdir(parents=True, exist_ok=True)
    write_whole(out, content)
    return parity


def _origin(file: Path, street: Street) -> dict[str, str]:
    """Return the origin of the network, for the file's metadata."""
    about = read_metadata(file)
    told = {name: str(about[name]) for name in ("recipe", "seed", "steps", "commit") if name in about}
    made = {
        "version": version("jaxwalk"),
        "policy_sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
        "config_sha256": hashlib.sha256(json.dumps(asdict(street.config), sort_keys=True).encode()).hexdigest(),
    }
    return {f"jaxwalk.{name}": value for name, value in {**made, **told}.items()}


def met(street: Street, role: str, policy: LearnedPolicy) -> Met:
    """Return what the policy observes and does in training scenarios, with people who always go or a route follower."""
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
    """Let the policy act, and return its action, its next memory and the record of both."""
    action, after = policy.act(key, memory, seen)
    return action, after, Met(seen, memory, action, policy.actor.network(seen))


def _rows(x: Array, *, axes: int) -> np.ndarray:
    """Return ``(time, *features, *agents, env)`` as ``(*features, row)``; ``axes``: number of agent and env axes."""
    kept = np.moveaxis(np.asarray(x), 0, -1)
    return kept.reshape(*kept.shape[: kept.ndim - axes - 1], -1)


def check_parity(content: bytes, policy: LearnedPolicy, met: Met) -> Parity:
    """Compare the network in an ONNX file with the policy on all recorded observations."""
    try:
        session = import_module("onnxruntime").InferenceSession(content, providers=["CPUExecutionProvider"])
    except ImportError as error:
        raise PolicyError("to check ONNX needs ONNX Runtime: pip install 'jaxwalk[onnx]'") from error
    memory = {} if met.memory is None else {"choice": met.memory.choice, "left": met.memory.steps_left}
    given = {"observation": np.ascontiguousarray(met.observation.T), **memory}
    names = [output.name for output in session.get_outputs()]
    found = dict(zip(names, session.run(None, given), strict=True))
    rows = met.observation.shape[1]
    if "logits" not in found:
        return Parity(rows, float(np.abs(found["action"].T - met.action).max()), 0)
    margin = np.abs(met.outputs[1] - met.outputs[0])
    other = (found["action"] != met.action) & (margin > LARGEST_GAP)
    return Parity(rows, float(np.abs(found["logits"].T - met.outputs).max()), int(other.sum()))

"""Where the policies that a name stands for come from, as results state it."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from jaxwalk.evaluation.document_parts import Kind, PolicyOrigin
from jaxwalk.policies import shipped_policy
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.policies.policy_names import RULES, is_class, is_host_driver
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.runs.contestant_names import policy_file

HASH_DIGITS = 16
"""Number of hexadecimal digits of a file's hash."""


def policy_origin(role: str, name: str) -> PolicyOrigin:
    """Return the origin of a driver or a population that `contestant` accepts. Raises its errors; loads nothing."""
    bare, shield = unshielded(role, name)
    if shield is not None:
        return replace(policy_origin(role, bare), name=name)
    mixed = mixture_of(role, name)
    if mixed:
        hashes = [policy_origin(role, kind).sha256 or kind for kind in mixed]
        return PolicyOrigin(name, "mixture", hashlib.sha256(" ".join(hashes).encode()).hexdigest()[:HASH_DIGITS])
    if name in RULES[role]:
        return PolicyOrigin(name, "rule", None)
    if role == "driver" and is_host_driver(name):
        python = is_class(name)
        file = _module_file(name.rpartition(":")[0]) if python else Path(name)
        return _hashed(name, "Python class" if python else "file", file)
    kind: Kind = "run folder" if Path(name).is_dir() else "policy file"
    return _hashed(name, "shipped policy" if shipped_policy(role, name) else kind, policy_file(role, name))


def _hashed(name: str, kind: Kind, file: Path | None) -> PolicyOrigin:
    content = file.read_bytes() if file is not None and file.is_file() else None
    return PolicyOrigin(name, kind, None if content is None else hashlib.sha256(content).hexdigest()[:HASH_DIGITS])


def _module_file(home: str) -> Path | None:
    """Return the file of a module, which may be one of the working folder; what it imports isn't looked at."""
    if home.endswith(".py"):
        return Path(home)
    local = Path(*home.split("."))
    for file in (local.with_suffix(".py"), local / "__init__.py"):
        if file.is_file():
            return file
    try:
        spec = find_spec(home)
    except ImportError:  # a package around it is missing
        return None
    return Path(spec.origin) if spec and spec.origin else None

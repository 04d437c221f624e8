"""What somebody, or a damaged disk, may do to a good file: strategies of hypothesis."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Mapping
from typing import Any

from hypothesis import strategies as st

Files = Mapping[str, bytes]
"""Contents by the names in a folder."""


def nested(depth: int) -> Any:
    """A list in a list in a list ..."""
    inner: Any = []
    for _ in range(depth):
        inner = [inner]
    return inner


NAMES = [
    "", " ", "None", "../../etc/passwd", "/dev/zero", "a\0b", "\u202e\U0001f697", "<script>alert(1)</script>",
    "x" * 10_000, "privileged", "global", "{{ 7 * 7 }}", "%s%n", "\n", "nan",
]  # fmt: skip
NUMBERS = [
    0, 1, -1, 2, 255, 2**31 - 1, 2**31, -(2**63), 2**63, 10**30, 0.0, -0.0, 0.5, 1e-300, 1e300, -1e300, float("nan"),
    float("inf"), float("-inf"),
]  # fmt: skip
VALUES = [*NAMES, *NUMBERS, None, True, False, [], {}, [None], {"": {}}, [[1.0, 2.0]], nested(20), list(range(300))]


def places(document: Any, path: tuple = ()) -> list[tuple]:
    """Where something stands in a document: keys and indices on the way to it."""
    inner = (
        document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    )
    return [place for key, value in inner for place in ((*path, key), *places(value, (*path, key)))]


def _replace(draw: Callable, holder: Any, key: Any) -> None:
    holder[key] = copy.deepcopy(draw(st.sampled_from(VALUES)))


def _remove(draw: Callable, holder: Any, key: Any) -> None:
    del holder[key]


def _rename(draw: Callable, holder: Any, key: Any) -> None:
    if isinstance(holder, dict):
        holder[draw(st.sampled_from(NAMES))] = holder.pop(key)


def _repeat(draw: Callable, holder: Any, key: Any) -> None:
    if isinstance(holder, list):
        holder[key:key] = [copy.deepcopy(holder[key])] * draw(st.sampled_from([1, 2, 100]))
    else:
        holder[draw(st.sampled_from(NAMES))] = copy.deepcopy(holder[key])


def _scale(draw: Callable, holder: Any, key: Any) -> None:
    if isinstance(holder[key], (int, float)):
        holder[key] = holder[key] * draw(st.sampled_from([-1, 3.6, 1000, 1e-3, 1e9]))


def _wrap(draw: Callable, holder: Any, key: Any) -> None:
    holder[key] = draw(st.sampled_from([lambda x: [x], lambda x: {"value": x}, str]))(holder[key])


CHANGES = [_replace, _replace, _replace, _remove, _rename, _repeat, _scale, _wrap]


@st.composite
def documents(draw: Callable, good: Any) -> Any:
    """A good document with 1 to 3 faults."""
    document = copy.deepcopy(good)
    for _ in range(draw(st.integers(1, 3))):
        found = places(document)
        if not found:
            break
        *way, key = draw(st.sampled_from(found))
        holder = document
        for step in way:
            holder = holder[step]
        draw(st.sampled_from(CHANGES))(draw, holder, key)
    return document


INSERTED = [
    b"", b"\0", b"\xff\xfe", b"\xc3\x28", b"[" * 20_000, b'{"a":' * 5_000, b"9" * 5_000, b"\n", b'"', b"NaN", b"1e999",
    b"\xff" * 8, b"\0" * 8, b"x" * 200_000, b"\xed\xa0\x80", b"\r\n\r\n", b",,,,", b"=", b"\x80\x04.",
]  # fmt: skip


@st.composite
def contents(draw: Callable, good: bytes) -> bytes:
    """Good bytes, damaged in 1 to 4 places."""
    content = good
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(content)))
        upto = min(len(content), at + draw(st.sampled_from([0, 1, 4, 8, 100, 10**9])))
        kind = draw(st.sampled_from(["cut", "insert", "flip", "copy"]))
        if kind == "flip":
            flipped = bytes(x ^ draw(st.sampled_from([1, 0x80, 0xFF])) for x in content[at : at + 1])
            content = content[:at] + flipped + content[at + 1 :]
        elif kind == "copy":
            content = content[:upto] + content[at : min(upto, at + 10_000)] + content[upto:]
        else:
            inserted = draw(st.sampled_from(INSERTED)) if kind == "insert" else b""
            content = content[:at] + inserted + content[upto:]
    return content


def damaged(files: Files) -> st.SearchStrategy[Files]:
    """One of the files has wrong bytes, or is missing."""
    wrong = st.sampled_from(sorted(files)).flatmap(
        lambda name: contents(files[name]).map(lambda content: {**files, name: content})
    )
    return st.one_of(
        wrong, wrong, wrong, st.sampled_from(sorted(files)).map(lambda n: {k: files[k] for k in files if k != n})
    )


def as_json(document: Any) -> bytes:
    """As Python writes it: with NaN and Infinity."""
    return json.dumps(document).encode("utf-8", "surrogatepass")


def as_toml(document: dict[str, Any]) -> bytes:
    """Of tables whose values are all written in line; what TOML can't say is left out."""
    return "".join(f"{json.dumps(key)} = {_toml(value)}\n" for key, value in document.items()).encode()


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(str(key))} = {_toml(x)}" for key, x in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return '"none"' if value is None else json.dumps(value, ensure_ascii=False).replace("\x7f", "")

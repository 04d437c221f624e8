"""The file of scripted tests and its parser. ``docs/crash-tests.md`` describes it for authors of tests."""

from __future__ import annotations

import tomllib
from importlib import resources
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from jaxwalk.maps.file import explain
from jaxwalk.scenarios.crash_faults import suite_faults
from jaxwalk.scenarios.crash_suite import MOST_BYTES, CrashFileError, CrashSuite
from jaxwalk.sim.suites import CRASH_SUITES

_ADAPTER = TypeAdapter(CrashSuite)


def load_crash_suite(name_or_path: str | Path) -> CrashSuite:
    """Return a suite that ships with jaxwalk, by its name, or that of a file. Raises CrashFileError."""
    source = str(name_or_path)
    if source in CRASH_SUITES:
        file = resources.files("jaxwalk.scenarios").joinpath("protocols", f"{source}.toml")
        return parse_crash_suite(file.read_text(encoding="utf-8"), source)
    if not source.endswith(".toml"):
        known = ", ".join(CRASH_SUITES)
        raise CrashFileError(
            f"{source}: no such suite of crash tests; use one of {known}, or the path of a .toml or .xosc file"
        )
    try:
        content = Path(source).read_bytes()[: MOST_BYTES + 1]
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise CrashFileError(f"{source}: cannot be read ({error.strerror}); check the path") from None
    except UnicodeDecodeError:
        raise CrashFileError(f"{source}: not UTF-8 text; save the file as UTF-8") from None
    if len(content) > MOST_BYTES:
        raise CrashFileError(f"{source}: larger than {MOST_BYTES:,} bytes, which no tests need; check the path")
    return parse_crash_suite(text, source)


def parse_crash_suite(text: str, source: str) -> CrashSuite:
    """Return the suite that a file's text describes. Raises CrashFileError, which names ``source``."""
    try:
        suite = _ADAPTER.validate_python(tomllib.loads(text))
    except ValidationError as error:
        raise CrashFileError(f"{source}: {first_fault(error)}; correct the file") from None
    except (ValueError, RecursionError) as error:  # TOMLDecodeError is a ValueError
        raise CrashFileError(f"{source}: not TOML that can be read ({error}); correct the file") from None
    return checked_suite(suite, source)


def first_fault(error: ValidationError) -> str:
    """Return the first thing that is wrong with the fields of a suite, in one line."""
    return explain(dict(error.errors()[0])).replace("(docs: maps)", "(docs: crash-tests)")


def checked_suite(suite: CrashSuite, source: str) -> CrashSuite:
    """Return a suite whose tests can be. Raises CrashFileError, which names ``source``."""
    for fault in suite_faults(suite):
        raise CrashFileError(f"{source}: {fault}")
    return suite

"""Thousands of bad files and command lines, none of which may end in a traceback, a hang or a half-written file.

    python tests/reliability/fuzz_loaders.py                       10,000 cases: 5 to 15 minutes
    python tests/reliability/fuzz_loaders.py --only map --cases 500
    python tests/reliability/fuzz_loaders.py --guided map --minutes 5    guided by what code is reached: needs atheris

Not collected by pytest; `tests/properties/test_bad_input.py` runs the same cases in small numbers. The first kind of
failure of each input is shown with its smallest case. Ends with 1 if there was any.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1]))
COMMANDS = "command lines"


def main() -> int:
    """Run what the command line asks for."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--cases", type=int, default=10_000, help="in all")
    asked.add_argument("--only", nargs="+", default=[], help="kinds of input")
    asked.add_argument("--guided", metavar="KIND", help="one kind of input, guided by coverage")
    asked.add_argument("--minutes", type=float, default=5.0, help="of the guided kind")
    options = asked.parse_args()
    os.environ.update(JAX_PLATFORMS="cpu", COLUMNS="200")
    if options.guided:
        return guided(options.guided, options.minutes)
    kinds = checks()
    if unknown := set(options.only) - kinds.keys():
        asked.error(f"no such kind: {', '.join(unknown)}; there are {', '.join(kinds)}")
    chosen = options.only or list(kinds)
    if len(chosen) == 1:
        return not many(chosen[0], *kinds[chosen[0]], options.cases)
    each = options.cases // len(chosen)
    command = [sys.executable, __file__, "--cases", str(each), "--only"]
    failed = [name for name in chosen if subprocess.run([*command, name]).returncode]  # (a library in C may crash)
    print(f"{len(chosen)} kinds of input, {each} cases of each, failed: {', '.join(failed) or 'none'}")
    return bool(failed)


def checks() -> dict[str, tuple[st.SearchStrategy, Callable[[Any], str | None]]]:
    """Of every kind of input: its cases, and what plays one and returns the message, if it was refused."""
    from hostile.command_lines import command_lines, nothing_is_done, prepare
    from hostile.judging import command, refused, unfinished
    from hostile.targets import make_targets, play

    def run(line: list[str]) -> str | None:
        here = Path.cwd()
        with tempfile.TemporaryDirectory() as folder, nothing_is_done():
            place = Path(folder) / "some" / "where"
            place.mkdir(parents=True)
            prepare(place)
            os.chdir(place)
            try:
                code, said = command(line)
                assert not unfinished(Path(folder)), line
            finally:
                os.chdir(here)
        return said if code else None

    found: dict[str, Any] = {COMMANDS: (command_lines(), run)}
    for name, target in make_targets().items():
        found[name] = target.hostile, lambda files, target=target: refused(lambda: play(target, files))
    return found


def many(name: str, cases: st.SearchStrategy, check: Callable[[Any], str | None], count: int) -> bool:
    """Whether that many cases all ended well."""
    ends, slowest, begun = Counter(), 0.0, time.monotonic()

    @settings(max_examples=count, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(cases)
    def one(case: Any) -> None:
        nonlocal slowest
        started = time.monotonic()
        ends["refused" if check(case) else "taken"] += 1
        slowest = max(slowest, time.monotonic() - started)

    well = True
    try:
        one()
    except Exception:
        traceback.print_exc()
        well = False
    took = time.monotonic() - begun
    told = ", ".join(f"{n} {end}" for end, n in sorted(ends.items()))
    print(f"{name}: {told}; {took:.0f} s, the slowest {slowest:.2f} s" + ("" if well else "; FAILED"), flush=True)
    return well


def guided(kind: str, minutes: float) -> int:
    """Let atheris look for bytes that reach new code (in Python; libraries in C are not watched)."""
    import atheris

    with atheris.instrument_imports(include=["jaxwalk", "tomllib", "safetensors"]):
        from hostile.judging import refused
        from hostile.targets import make_targets, play
    target = make_targets()[kind]
    first, *others = sorted(target.files)

    def one(content: bytes) -> None:
        refused(lambda: play(target, {**{name: target.files[name] for name in others}, first: content}))

    with tempfile.TemporaryDirectory() as corpus:
        (Path(corpus) / "good").write_bytes(target.files[first])
        limits = [f"-max_total_time={round(60 * minutes)}", "-timeout=30", "-rss_limit_mb=8000", "-max_len=20000"]
        atheris.Setup([sys.argv[0], *limits, corpus], one)
        atheris.Fuzz()  # (ends the process)
    return 0


if __name__ == "__main__":
    sys.exit(main())

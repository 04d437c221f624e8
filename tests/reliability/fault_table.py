"""The faults that `faults.py` plays, the commands that meet them, and how each may end."""

from __future__ import annotations

import signal
from dataclasses import dataclass, field

OUT = "kept"
"""Where every command writes."""
SMALL = "--environments 8 --steps 8 --minibatches 2 --updates 2"
LONG = ("sweep", "reproduce", "hidden-intent", "co-training", "generalisation", "risk-aware", "frontier")
"""Commands that take minutes: they meet the faults that end them."""
COMMANDS = {
    "observations": "observations",
    "measure": "measure tracks.parquet",
    "evaluate": f"evaluate --driver random --episodes 2 --out {OUT}",
    "merge": f"merge part --out {OUT}",
    "train": f"train --run new {SMALL}",
    "sweep": "sweep study.toml --out new",
    "play": f"play --driver random --out {OUT}/a.html",
    "export": f"export co-trained --out {OUT}/a.onnx",
    "tracks": f"tracks --driver random --out {OUT}/a.parquet",
    "scenario": f"scenario --driver random --out {OUT}",
    "share": f"share run --episodes 2 --out {OUT}/a.safetensors",
    "submit": f"submit entry --out {OUT}/a.md",
    "crashtest": f"crashtest random --suite r152 --beside none --out {OUT}",
    "search": f"search route-follower --simulations 1 --minimise 0 --out {OUT}",
    "report": f"report random --pedestrians always-go --episodes 2 --incidents 0 --out {OUT}",
    "rate": f"rate clearance careful-human --episodes 64 --pairs 3 --out {OUT}",
    "live": f"live --port 0 --minutes 0.05 --out {OUT}",
    "bench": f"bench --only env --environments 8 --seconds 0.05 --out {OUT}",
    "reproduce": "reproduce --updates 1 --episodes 2 --out new",
    "hidden-intent": "hidden-intent --updates 1 --episodes 2 --seeds 1 --out new",
    "co-training": "co-training --updates 1 --episodes 2 --seeds 2 --out new",
    "generalisation": "generalisation --updates 1 --episodes 2 --seeds 1 --out new",
    "risk-aware": "risk-aware --updates 1 --episodes 2 --seeds 1 --out new",
    "frontier": "frontier --suite paper --driver random --episodes 2 --out new",
    "streets": f"streets --count 1 --out {OUT}",
    "import": f"import cross.osm --out {OUT}",
    "map new": f"map new {OUT}/new.toml",
    "map check": "map check paper",
    "map draw": f"map draw paper --out {OUT}/a.png",
}
"""Every command, with little work."""
WRITES = {
    "evaluate": ("results.json", "suite.md", "episodes.csv"), "play": ("a.html",), "export": ("a.onnx",),
    "tracks": ("a.parquet",), "scenario": ("episode.xosc", "map.xodr", "commonroad.xml"),
    "share": ("a.safetensors", "a.md"), "submit": ("a.md",), "report": ("report.html", "results.json", "episodes.csv"),
    "bench": ("bench.json", "bench.md"), "streets": ("streets.png",), "map draw": ("a.png",),
    "import": ("report.html", "report.json"),
    "crashtest": ("crashtest.html", "crashtest.json", "crashtest.csv"), "rate": ("rate.html", "plan.json"),
    "merge": ("results.json", "suite.md", "episodes.csv"),
    "search": ("search.html", "search.json", "failures.csv"),
}  # fmt: skip
"""Files of an earlier time that a command replaces: all of them, or none."""


@dataclass(frozen=True)
class Fault:
    """Something that is wrong around a command."""

    name: str
    line: str = "J"
    """A line for the shell, in which J stands for the command."""
    environment: dict[str, str | None] = field(default_factory=dict)
    """Variables to set, or (None) to unset."""
    send: tuple[int, ...] = ()
    """Signals to send."""
    after: float = 1.0
    """Seconds until the first one."""
    codes: tuple[int, ...] = (0,)
    """Exit codes with which the command may end."""
    without: tuple[str, ...] = ()
    """Commands that don't meet it."""

    @property
    def ends(self) -> bool:
        """Whether it ends the command early."""
        return bool(self.send) or 0 not in self.codes


NO_OUTPUT = ("train", *LONG)
"""Commands that print nothing on standard output, or only in the end."""
NO_FILES = ("observations", "measure", "map check", "live")
INT, TERM, HUP = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
UNTIL = {INT: 130, TERM: 143, HUP: 143}
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
NO_CACHE = {"JAX_COMPILATION_CACHE_DIR": None}

FAULTS = (
    # The environment: JAX can't start.
    *(
        Fault(f"{name}={value}", environment={name: value}, codes=(2,))
        for name, value in (
            ("JAX_PLATFORMS", "nonsense"), ("JAX_NUM_CPU_DEVICES", "abc"), ("JAX_NUM_CPU_DEVICES", "0"),
            ("JAX_ENABLE_X64", "maybe"), ("XLA_FLAGS", "--nonsense"), ("XLA_FLAGS", "/nowhere"),
        )
    ),
    # The environment: it works all the same.
    Fault("no HOME", environment={"HOME": None}),
    Fault("HOME=/dev/null", environment={"HOME": "/dev/null", "XDG_CACHE_HOME": None, **NO_CACHE}),
    Fault("XDG_CACHE_HOME=/dev/null", environment={"XDG_CACHE_HOME": "/dev/null", **NO_CACHE}),
    Fault("a cache below a file", environment={"JAX_COMPILATION_CACHE_DIR": "/dev/null/cache"}),
    Fault("LC_ALL=C in ASCII", environment=ASCII),
    Fault("PYTHONIOENCODING=ascii", environment={"PYTHONIOENCODING": "ascii"}),
    Fault("COLUMNS=1", environment={"COLUMNS": "1", "TERM": "dumb"}),
    Fault("COLUMNS=abc", environment={"COLUMNS": "abc", "LINES": "-1"}),
    Fault("MPLBACKEND=nonsense", environment={"MPLBACKEND": "nonsense"}),
    Fault("MPLCONFIGDIR=/dev/null", environment={"MPLCONFIGDIR": "/dev/null"}),
    Fault("TMPDIR=/nowhere", environment={"TMPDIR": "/nowhere"}),
    Fault("an empty PATH", environment={"PATH": ""}),
    Fault("TZ=nonsense", environment={"TZ": "nonsense"}),
    Fault("GIT_DIR=/dev/null", environment={"GIT_DIR": "/dev/null"}),
    # Streams.
    Fault("closed output", "J >&-"),
    Fault("closed errors", "J 2>&-"),
    Fault("closed input", "J <&-"),
    Fault("all closed", "J <&- >&- 2>&-"),
    Fault("output nobody reads", "J | true"),
    Fault("output read in part", "J | head -1"),
    Fault("messages nobody reads", "J 2>&1 >/dev/null | true"),
    Fault("full output", "J >/dev/full", codes=(2,), without=NO_OUTPUT),
    Fault("full messages", "J 2>/dev/full"),
    Fault("full output and messages", "J >/dev/full 2>&1", codes=(2,), without=NO_OUTPUT),
    # Signals.
    *(
        Fault(f"{number.name} after {after:g} s", send=(number,), after=after, codes=(0, UNTIL[number]))
        for number in (INT, TERM, HUP) for after in (1, 4)
    ),
    *(
        Fault(f"{first.name}, then {second.name}", send=(first, second), after=3, codes=(0, UNTIL[first]))
        for first, second in ((INT, INT), (TERM, TERM), (INT, TERM), (HUP, HUP))
    ),
    Fault("nohup, then a hangup", "trap '' HUP; J", send=(HUP,), codes=(0,), without=LONG),
    # The disk.
    Fault("no file may grow", "ulimit -f 0; J", codes=(2,), without=(*NO_FILES, "train")),
    Fault("files of 1 kB at most", "ulimit -f 1; J", codes=(2,), without=(*NO_FILES, "train", "share", "scenario")),
    Fault("a file in the way", f"rm -rf {OUT} new; touch {OUT} new; J", codes=(2,), without=NO_FILES),
    Fault("a folder that can't be made", f"rm -rf {OUT} new; ln -s /proc/nowhere {OUT}; ln -s /proc/nowhere new; J",
          codes=(2,), without=NO_FILES),
    Fault("no working folder", "mkdir gone; cd gone; rmdir ../gone; J", codes=(0, 2)),
)  # fmt: skip
"""Faults of the environment, of streams, signals and the disk."""

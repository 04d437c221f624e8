"""Entries of a leaderboard for tests: what changes a file, and a driver in Python."""

from __future__ import annotations

import json
from contextlib import chdir
from dataclasses import asdict

from jaxwalk.runs.policy_origins import policy_origin

DRIVER = """
import network

class Driver:
    pedal = network.PEDAL
    def act(self, seen):
        raise ValueError
"""


def change(path, how):
    """Change the content of a JSON file."""
    content = json.loads(path.read_text())
    how(content)
    path.write_text(json.dumps(content))


def python_entry(entry, files):
    """Put files into an entry, and let its results name ``driver.py:Driver`` among them as its driver."""
    for name, text in files.items():
        (entry / name).parent.mkdir(exist_ok=True)
        (entry / name).write_text(text)
    with chdir(entry):
        origin = asdict(policy_origin("driver", "driver.py:Driver"))

    def claims(content):
        content["drivers"][0] = origin
        content["cells"][0].update(driver=origin["name"])

    change(entry / "results.json", claims)

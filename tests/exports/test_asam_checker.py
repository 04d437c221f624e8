"""ASAM's checker of OpenSCENARIO finds nothing in what is exported, and something in what is damaged.

It needs an environment of its own, whose Python JAXWALK_ASAM names; without it these tests are skipped.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from exports.failures import POLICIES, kept_failure
from jaxwalk.exports.scenario_files import export_scenario, export_tests
from jaxwalk.scenarios import Drawn, Scripted
from jaxwalk.scenarios.crash_file import load_crash_suite
from jaxwalk.scenarios.staging import layers_of
from jaxwalk.sim.suites import CRASH_SUITES

PYTHON = os.environ.get("JAXWALK_ASAM", "")
CHECKER = Path(__file__).with_name("asam_checker.py")
pytestmark = pytest.mark.skipif(not PYTHON, reason="JAXWALK_ASAM names no Python with asam-qc-openscenarioxml")


def check(*files):
    """Return the exit code of the checker, and what it said."""
    done = subprocess.run([PYTHON, CHECKER, *files], capture_output=True, text=True, check=False, timeout=300)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Every run of every suite that ships, in all layers."""
    folder = tmp_path_factory.mktemp("tests")
    for name in CRASH_SUITES:
        suite = load_crash_suite(name)
        count, refused = export_tests(Scripted.of(suite, name, layers=layers_of(suite)), folder / name)
        assert count > 10 * len(refused)
    return sorted(folder.rglob("*.xosc"))


def test_every_shipped_test_that_can_be_said_passes(written):
    assert len(written) > 300
    assert check(*written) == (0, f"{len(written)} files, 0 faults\n")


def test_an_episode_and_a_failure_pass(street, tmp_path):
    export_scenario(street, POLICIES, Drawn(street, 0), 3, tmp_path / "drawn", name="drawn")
    export_scenario(street, POLICIES, kept_failure(street), 0, tmp_path / "kept", name="kept")
    assert check(*sorted(tmp_path.rglob("*.xosc"))) == (0, "2 files, 0 faults\n")


@pytest.mark.parametrize(
    ("old", "new"),
    [('entityRef="pedestrian1"', 'entityRef="nobody"'), ("<Dimensions", "<Size"), ('name="pedestrian1"', 'name="Ego"')],
    ids=["nobody", "no such element", "two of one name"],
)
def test_a_damaged_file_fails(written, tmp_path, old, new):
    text = written[0].read_text()
    assert old in text
    (tmp_path / "damaged.xosc").write_text(text.replace(old, new, 1))
    code, said = check(tmp_path / "damaged.xosc")
    assert code == 1 and "damaged.xosc: " in said

"""Checkpoints that can't be read or written: the one before is gone on from, and nothing is in the way."""

from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.learning.checkpoint import DamagedError, latest, restore, restore_newest, save
from limits import files_at_most


def _learner(number):
    return {"weights": jnp.asarray(np.random.default_rng(number).normal(size=(200, 200)), jnp.float32)}


@pytest.fixture
def two(tmp_path):
    """A folder with checkpoints 1 and 2."""
    for number in (1, 2):
        save(tmp_path, _learner(number), updates=number)
    return tmp_path


def _damage(checkpoint):
    """Cut the file that holds the numbers short, as a power failure may."""
    file = max((path for path in checkpoint.rglob("*") if path.is_file()), key=lambda path: path.stat().st_size)
    file.write_bytes(file.read_bytes()[:100])


def test_the_newest_is_taken(two):
    said = []
    found = restore_newest(two, _learner(0), tell=said.append)
    np.testing.assert_array_equal(found["weights"], _learner(2)["weights"])
    assert said == []


def test_without_any_there_is_none(tmp_path):
    assert restore_newest(tmp_path / "nowhere", _learner(0), tell=print) is None


def test_a_damaged_one_makes_way_for_the_older_and_for_those_to_come(two):
    _damage(two / "2")
    said = []
    found = restore_newest(two, _learner(0), tell=said.append)
    np.testing.assert_array_equal(found["weights"], _learner(1)["weights"])
    assert len(said) == 1
    assert "checkpoint 2 can't be read" in said[0]
    assert said[0].endswith("it is now 2.damaged, and training goes on from checkpoint 1")
    assert latest(two) == 1
    save(two, _learner(2), updates=2)
    np.testing.assert_array_equal(restore(two, _learner(0))["weights"], _learner(2)["weights"])


def test_if_all_are_damaged_they_stay_and_it_is_said(two):
    for number in ("1", "2"):
        _damage(two / number)
    with pytest.raises(DamagedError, match=r"checkpoint 2 can't be read .*; neither can an older one. Start again"):
        restore_newest(two, _learner(0), tell=print)
    assert sorted(path.name for path in two.iterdir()) == ["1", "2"]


def test_a_disk_with_too_little_room_is_told_of_before_anything_is_written(two, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1_100_000))  # the arrays have 160,000 bytes
    with pytest.raises(OSError, match="No space left") as caught:
        save(two, _learner(3), updates=3)
    assert caught.value.filename == str(two)
    assert sorted(path.name for path in two.iterdir()) == ["1", "2"]
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1_200_000))
    save(two, _learner(3), updates=3)
    assert latest(two) == 3


def test_a_file_that_grows_too_large_leaves_those_before(two):
    with files_at_most(1000), pytest.raises(OSError, match="File too large") as caught:
        save(two, _learner(3), updates=3)
    assert caught.value.filename == str(two / "3")
    assert sorted(path.name for path in two.iterdir()) == ["1", "2"]
    np.testing.assert_array_equal(restore(two, _learner(0))["weights"], _learner(2)["weights"])
    save(two, _learner(3), updates=3)
    assert sorted(path.name for path in two.iterdir()) == ["2", "3"]

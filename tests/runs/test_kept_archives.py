"""A training mixes in scenarios of an archive: those alone, in the share that is asked for, from a kept copy."""

from __future__ import annotations

import shutil
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.cli import main
from jaxwalk.recipes import Experiment
from jaxwalk.runs.binding import EditedConfigError
from jaxwalk.runs.folder import Run
from jaxwalk.runs.kept_archives import KeptArchiveError
from jaxwalk.runs.progress import Display
from jaxwalk.runs.street import crowded, make_street
from jaxwalk.runs.training import train_in
from jaxwalk.scenarios import Archived
from jaxwalk.scenarios.archive_file import ArchiveError, write_archive
from jaxwalk.search.cube import ordinary
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario, dimensions, from_uniforms

COUNT = 3


def archive(path, street: Street, *, present: bool = True) -> Archived:
    """Write a few ordinary scenarios of a street, as if a search had found them."""
    points = ordinary(np.random.default_rng(1), COUNT, dimensions(street.world))
    there = np.full((COUNT, street.config.pedestrians), present)
    kept = Archived(street, points, there, 0, np.arange(COUNT))
    write_archive(path, kept, {})
    return kept


@pytest.fixture
def mixing(tiny, tmp_path) -> Experiment:
    """The tiny training with an archive of its street."""
    archive(tmp_path / "found.safetensors", make_street(tiny))
    return replace(tiny, archives=(str(tmp_path / "found.safetensors"),))


def drawn(street: Street, count: int = 400) -> Scenario:
    return jax.vmap(street.draw, out_axes=-1)(jax.random.split(jax.random.key(5), count))


def from_archive(street: Street, scenarios: Scenario) -> np.ndarray:
    """Return which scenario of the archive each of the drawn ones is; -1: none of them."""
    (kept,) = street.kept.values()
    own = jax.vmap(lambda point: from_uniforms(street.world, point).traits)(kept.points)
    same = (np.asarray(own)[..., None] == np.asarray(scenarios.traits)[None]).all(axis=(1, 2))
    return np.where(same.any(axis=0), same.argmax(axis=0), -1)


@pytest.mark.parametrize("share", [0.25, 1.0])
def test_episodes_begin_with_scenarios_of_the_archive_in_that_share(mixing, share):
    street = make_street(replace(mixing, archive_share=share))
    which = from_archive(street, drawn(street))
    assert abs((which >= 0).mean() - share) <= 3 * np.sqrt(share * (1 - share) / 400)
    each = np.bincount(which[which >= 0], minlength=COUNT) / (which >= 0).sum()
    np.testing.assert_allclose(each, 1 / COUNT, atol=0.15)


def test_all_others_are_drawn_anew(mixing):
    street = make_street(mixing)
    traits = np.asarray(drawn(street).traits)[0, 0]
    others = traits[from_archive(street, drawn(street)) < 0]
    assert len(np.unique(others)) > 0.95 * len(others)
    assert abs(others.mean() - 0.5) < 0.06


def test_without_an_archive_nothing_changes(tiny, mixing):
    plain, emptied = make_street(tiny), replace(make_street(mixing), kept={})
    assert eqx.tree_equal(drawn(plain, 4), drawn(emptied, 4))


def test_an_archive_is_met_where_its_number_of_people_plays(tiny, tmp_path):
    archive(tmp_path / "three.safetensors", make_street(tiny).with_people(3))
    roles = {name: replace(role, critic_observes=(role.observes,)) for name, role in tiny.train.roles.items()}
    crowds = replace(tiny, train=replace(tiny.train, roles=roles), crowds=(12, 3), archives=(str(tmp_path),))
    shutil.copy(tmp_path / "three.safetensors", tmp_path / "scenarios.safetensors")
    twelve, three = crowded(make_street(replace(crowds, archive_share=1.0)), crowds)
    assert (from_archive(three, drawn(three, 9)) >= 0).all()
    assert len(np.unique(np.asarray(drawn(twelve, 9).traits)[0, 0])) == 9


def test_an_interrupted_training_goes_on_with_the_copy_that_its_folder_keeps(mixing, tmp_path, quiet):
    whole, cut = (Run.create(tmp_path / name, mixing) for name in ("whole", "cut"))
    (tmp_path / "found.safetensors").unlink()
    train_in(whole, display=Display(quiet))
    assert train_in(cut, display=Display(quiet), on_update=lambda line: line["update"] == 2).stopped
    train_in(Run.open(cut.path), resume=True, display=Display(quiet))
    assert cut.policy.read_bytes() == whole.policy.read_bytes()


def test_another_copy_is_refused(mixing, tmp_path, quiet):
    run = Run.create(tmp_path / "run", mixing)
    train_in(run, display=Display(quiet))
    street = make_street(mixing)
    kept = archive(tmp_path / "found.safetensors", street)
    write_archive(run.archives[0], replace(kept, keys=kept.keys + 1), {})
    with pytest.raises(EditedConfigError, match="the content of the archives"):
        train_in(run, resume=True, display=Display(quiet))
    run.archives[0].unlink()
    with pytest.raises(ArchiveError, match=r"archive-0\.safetensors: no such file"):
        train_in(run, resume=True, display=Display(quiet))


def _other_map(street):
    return Street.create(("test:1",), street.config)


def _other_rules(street):
    return Street.create(street.maps, replace(street.config, max_speed=9.0))


WRONG = {
    "another map": (_other_map, True, r"of other maps than the training's, paper; search with --map"),
    "another crowd": (lambda street: street.with_people(3), True, r"have 3 people, the training's have 12; search"),
    "another world": (_other_rules, True, r"another world than the training's \(max_speed differ\)"),
    "minimised": (lambda street: street, False, r"people are absent in its scenarios, as in minimised ones; name"),
}


@pytest.mark.parametrize(("made", "present", "message"), WRONG.values(), ids=WRONG)
def test_an_archive_that_the_training_could_not_draw_is_refused(tiny, tmp_path, made, present, message):
    archive(tmp_path / "found.safetensors", made(make_street(tiny)), present=present)
    with pytest.raises(KeptArchiveError, match=message):
        make_street(replace(tiny, archives=(str(tmp_path / "found.safetensors"),)))


def test_the_command_line_says_what_is_wrong_before_it_writes(tmp_path, capsys):
    run = str(tmp_path / "run")
    assert main(["train", "--run", run, "--archive", str(tmp_path / "none.safetensors")]) == 2
    assert "none.safetensors: no such file; check the name" in capsys.readouterr().err
    assert main(["train", "--run", run, "--archive", "x", "--archive-share", "1.5"]) == 2
    assert "archive_share must be above 0 and at most 1, not 1.5" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()

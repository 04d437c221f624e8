"""A training mixes in scenarios of an archive: those alone, in the share that is asked for, from a kept copy."""

from __future__ import annotations

import io
import json
import shutil
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest
from rich.console import Console

from jaxwalk.cli import main
from jaxwalk.policies import read_metadata
from jaxwalk.recipes import RECIPES, Experiment, ExperimentFileError, load_experiment
from jaxwalk.runs.binding import EditedConfigError
from jaxwalk.runs.folder import Run
from jaxwalk.runs.kept_archives import KeptArchiveError, archive_hashes
from jaxwalk.runs.progress import Display
from jaxwalk.runs.street import crowded, make_street
from jaxwalk.runs.training import train_in
from jaxwalk.scenarios.archive_file import SCENARIOS, write_archive
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario, draw, from_uniforms
from scenarios.small_archive import COUNT, write_small_archive


@pytest.fixture
def mixing(tiny, tmp_path) -> Experiment:
    """The tiny training with an archive of its street."""
    write_small_archive(tmp_path / "found.safetensors", make_street(tiny))
    return replace(tiny, archives=(str(tmp_path / "found.safetensors"),))


@eqx.filter_jit
def drawn(street: Street, count: int = 400) -> Scenario:
    return jax.vmap(street.draw, out_axes=-1)(jax.random.split(jax.random.key(5), count))


@eqx.filter_jit
def kept_traits(street: Street) -> jax.Array:
    """Return the traits of the archive's scenarios."""
    (kept,) = street.kept.values()
    return jax.vmap(lambda point: from_uniforms(street.world, point).traits)(kept.points)


def from_archive(street: Street, scenarios: Scenario) -> np.ndarray:
    """Return which scenario of the archive each of the drawn ones is; -1: none of them."""
    same = (np.asarray(kept_traits(street))[..., None] == np.asarray(scenarios.traits)[None]).all(axis=(1, 2))
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


def test_where_another_number_of_people_plays_all_is_drawn_as_without_an_archive(mixing):
    street = make_street(mixing).with_people(3)
    keys = jax.random.split(jax.random.key(5), 4)
    plain = jax.jit(jax.vmap(lambda key: draw(street.world, key), out_axes=-1))(keys)
    assert eqx.tree_equal(*jax.device_get((drawn(street, 4), plain)))


def test_an_archive_is_met_where_its_number_of_people_plays(tiny, tmp_path):
    write_small_archive(tmp_path / SCENARIOS, make_street(tiny).with_people(3))
    roles = {name: replace(role, critic_observes=(role.observes,)) for name, role in tiny.train.roles.items()}
    crowds = replace(tiny, train=replace(tiny.train, roles=roles), crowds=(12, 3), archives=(str(tmp_path),))
    twelve, three = crowded(make_street(replace(crowds, archive_share=1.0)), crowds)
    assert (from_archive(three, drawn(three, 9)) >= 0).all()
    assert len(np.unique(np.asarray(drawn(twelve, 9).traits)[0, 0])) == 9


@pytest.fixture(scope="module")
def mixed(tiny, tmp_path_factory):
    """Two run folders of one training, the first one trained; the archive that they name is gone."""
    folder = tmp_path_factory.mktemp("mixed")
    archive = folder / "found.safetensors"
    write_small_archive(archive, make_street(tiny))
    experiment = replace(tiny, archives=(str(archive),), archive_share=0.5)
    whole, cut = (Run.create(folder / name, experiment) for name in ("whole", "cut"))
    archive.unlink()
    train_in(whole, display=Display(Console(file=io.StringIO())))
    return whole, cut


@pytest.mark.long
def test_an_interrupted_training_goes_on_with_the_copy_that_its_folder_keeps(mixed, quiet):
    whole, cut = mixed
    assert train_in(cut, display=Display(quiet), on_update=lambda line: line["update"] == 2).stopped
    train_in(Run.open(cut.path), resume=True, display=Display(quiet))
    assert cut.policy.read_bytes() == whole.policy.read_bytes()


@pytest.mark.long
def test_another_copy_is_refused(mixed, tiny, tmp_path, quiet):
    run = Run.open(shutil.copytree(mixed[0].path, tmp_path / "run"))
    kept = write_small_archive(tmp_path / "found.safetensors", make_street(tiny))
    write_archive(run.archives[0], replace(kept, points=kept.points[::-1].copy()), {})
    with pytest.raises(EditedConfigError, match=r"the kept scenarios aren't those of checkpoint 6; restore archive-N"):
        train_in(run, resume=True, display=Display(quiet))
    run.archives[0].unlink()
    with pytest.raises(KeptArchiveError, match=r"archive-0\.safetensors: missing; copy it again"):
        train_in(run, resume=True, display=Display(quiet))


def _other_map(street):
    return Street.create(("test:1",), street.config)


def _other_rules(street):
    return Street.create(street.maps, replace(street.config, max_speed=9.0))


WRONG = {
    "another map": (_other_map, True, r"of the maps test-\d+, the training's are paper; search with --map"),
    "another crowd": (lambda street: street.with_people(3), True, r"have 3 people, the training's have 12; search"),
    "another world": (
        _other_rules,
        True,
        r"where max_speed is 9\.0, not 8\.33 as in the training's; search",
    ),
    "minimised": (lambda street: street, False, r"people are absent in its scenarios, as in minimised ones; name"),
}


@pytest.mark.parametrize(("made", "present", "message"), WRONG.values(), ids=WRONG)
def test_an_archive_that_the_training_could_not_draw_is_refused(tiny, tmp_path, made, present, message):
    write_small_archive(tmp_path / "found.safetensors", made(make_street(tiny)), present=present)
    with pytest.raises(KeptArchiveError, match=message):
        make_street(replace(tiny, archives=(str(tmp_path / "found.safetensors"),)))


def test_maps_in_another_order_are_said_to_be(tiny, tmp_path):
    two = replace(tiny, maps=("paper", "test:1"))
    street = make_street(two)
    write_small_archive(tmp_path / "found.safetensors", Street.create(street.maps[::-1], street.config))
    with pytest.raises(KeptArchiveError, match=r"test-\d+, paper, the training's in another order are paper, "):
        make_street(replace(two, archives=(str(tmp_path / "found.safetensors"),)))


def test_archives_of_one_crowd_join_and_none_counts_twice(mixing, tmp_path):
    write_small_archive(tmp_path / "more.safetensors", make_street(mixing), seed=2)
    both = replace(mixing, archives=(*mixing.archives, str(tmp_path / "more.safetensors")))
    assert len(make_street(both).kept[12].points) == 2 * COUNT
    with pytest.raises(KeptArchiveError, match="are those of another archive; name it once"):
        make_street(replace(both, archives=mixing.archives * 2))


def test_a_file_names_archives_beside_it(mixing, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('archives = ["found.safetensors"]\narchive_share = 0.5\n')
    found = load_experiment(file, RECIPES)
    assert (found.archives, found.archive_share) == (mixing.archives, 0.5)
    file.write_text("archive_share = 0.5\n")
    with pytest.raises(ExperimentFileError, match="archive_share: there are no archives; add archives"):
        load_experiment(file, RECIPES)


@pytest.mark.long
def test_a_command_mixes_an_archive_in_and_its_policy_says_so(tiny, mixing, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(RECIPES, "fast", tiny)  # so that nothing is compiled that another test hasn't
    run = tmp_path / "run"
    line = f"train --run {run} --recipe fast --shards 1 --archive {mixing.archives[0]} --archive-share 0.5"
    assert main(line.split()) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "50 % of the episodes with 12 pedestrians begin with one of 3 kept scenarios" in said
    assert read_metadata(run / "policy.safetensors")["archive_hashes"] == archive_hashes(make_street(mixing))
    config = json.loads((run / "config.json").read_text())
    assert (config["archives"], config["archive_share"]) == ([mixing.archives[0]], 0.5)


def test_the_command_line_says_what_is_wrong_before_it_writes(mixing, tmp_path, capsys):
    (tmp_path / "unfinished").mkdir()
    write_small_archive(tmp_path / "other.safetensors", _other_map(make_street(mixing)))
    wrong = {
        f"--archive {tmp_path / 'none.safetensors'}": "none.safetensors: no such file; check the name",
        f"--archive {tmp_path / 'unfinished'}": "this found no failure or isn't finished",
        f"--archive {tmp_path / 'other.safetensors'}": "search with --map on the training's",
        "--archive x --archive-share 1.5": "archive_share must be above 0 and at most 1, not 1.5",
        "--archive": "--archive needs a file of scenarios, or the folder of a search",
        "--archive-share 0.5": "--archive-share is the share of the scenarios of --archive; name some, or leave it out",
    }
    for words, message in wrong.items():
        assert main(["train", "--run", str(tmp_path / "run"), *words.split()]) == 2
        assert message in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "run").exists()

"""An evaluation in parts has the numbers of an evaluation of all, to the last bit."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation.document_parts import EvaluationOptions
from jaxwalk.evaluation.parts import PART, Part, PartError, complete, read_part
from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.evaluation.row_files import no_rows
from jaxwalk.evaluation.settings import with_jaywalk_multiplier
from jaxwalk.evaluation.stored_rows import StoredRowsError, StoredTable
from jaxwalk.experiments.evaluating import Evaluation, evaluate_all
from jaxwalk.experiments.in_parts import evaluate_part, merge_parts
from jaxwalk.experiments.kept_parts import KeptParts
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.metrics import statistics
from jaxwalk.metrics.encounters import ENCOUNTERS, Encounters
from jaxwalk.policies import AlwaysGo, ConstantSpeed
from jaxwalk.scenarios import Archived
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import dimensions

AT_ONCE, BATCH, CHUNK, EPISODES, PARTS = 4, 8, 16, 36, 3
"""36 episodes are five blocks, the last one half full; parts have one, two and two. Each is played in two batches."""
FILES = ("results.json", "suite.md", "episodes-x0.25.csv", "episodes-x1.csv")


def ignore(*_):
    """Tell nobody."""


@pytest.fixture(scope="module")
def patch():
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.fixture(scope="module")
def work(patch):
    """An evaluation with two cells, by one compiled program."""
    patch.setattr("jaxwalk.evaluation.batches.BATCH", AT_ONCE)
    for module in ("metrics.statistics", "experiments.in_parts", "evaluation.parts", "evaluation.stored_rows"):
        patch.setattr(f"jaxwalk.{module}.CHUNK", CHUNK)
    multipliers, alike = (0.25, 1.0), ("constant-speed", "constant-speed")
    street = Street.create()
    return Evaluation(
        streets=tuple(with_jaywalk_multiplier(street, multiplier) for multiplier in multipliers),
        drivers={"constant-speed": ConstantSpeed()},
        populations={"always-go": AlwaysGo()},
        scenarios=Scenarios(EPISODES, 7),
        options=EvaluationOptions(multipliers, compare=alike, encounters=True),
    )


@pytest.fixture(scope="module")
def parts(work, tmp_path_factory, patch):
    """The folder of an evaluation of all, ``whole``, and of its parts ``1`` to ``3``."""
    folder, relieved = tmp_path_factory.mktemp("parts"), []
    patch.setattr("jaxwalk.evaluation.batches.relieve", lambda: relieved.append(1))
    evaluate_all(replace(work, out=folder / "whole"), ignore)
    for number in range(1, PARTS + 1):
        evaluate_part(work, Part(number, PARTS), folder / str(number), ignore, batch=BATCH)
    assert len(relieved) == len(work.streets) * (1 + PARTS), "the memory of old programs is given back after each cell"
    return folder


@pytest.fixture
def copied(parts, tmp_path):
    """A copy of the parts, which may be damaged."""
    for number in range(1, PARTS + 1):
        shutil.copytree(parts / str(number), tmp_path / str(number))
    return tmp_path


def merged(folder, *names):
    return merge_parts([read_part(folder / str(name)) for name in names], folder / "merged", ignore)


def test_a_merge_writes_what_an_evaluation_of_all_writes(parts):
    from pyarrow import parquet

    found = merged(parts, 3, 1, 2)
    for name in FILES:
        assert (parts / "merged" / name).read_bytes() == (parts / "whole" / name).read_bytes(), name
    one, other = (parquet.read_table(parts / name / "encounters.parquet") for name in ("whole", "merged"))
    assert one.equals(other)
    assert found.said == ()
    assert found.results.scenarios.count == EPISODES


def test_a_part_that_was_killed_is_run_again_and_a_part_run_twice_counts_once(parts, work):
    def kill(what, done, total):
        raise KeyboardInterrupt

    again, number = parts / "again", Part(2, PARTS)
    with pytest.raises(KeyboardInterrupt):
        evaluate_part(work, number, again, kill, batch=BATCH)
    assert not list(again.iterdir())
    (again / ".outcomes.1.part.parquet").write_bytes(b"what a process leaves that is killed at once")
    evaluate_part(work, number, again, ignore, batch=BATCH)
    assert {path.name for path in again.iterdir()} == {path.name for path in (parts / "2").iterdir()}
    chosen, said = complete([read_part(parts / name) for name in ("2", "3", "again", "1")])
    assert [part.folder.name for part in chosen] == ["1", "2", "3"]
    assert said == [f"{again}: part 2/3 again, with the same rows; left out"]


def test_parts_that_come_as_files_are_kept_until_none_is_missing(parts, work, tmp_path):
    kept = KeptParts.of(work, tmp_path / "kept", PARTS, batch=BATCH)
    assert kept.names == kept.missing() == ["1/3", "2/3", "3/3"]
    assert [kept.episodes(name) for name in kept.names] == [8, 16, 12]
    for number in (3, 1):
        kept.keep(f"{number}/3", {path.name: path.read_bytes() for path in (parts / str(number)).iterdir()})
    (tmp_path / "kept" / "2").mkdir()
    (tmp_path / "kept" / "2" / "outcomes.parquet").write_bytes(b"of a command that was killed")
    again = KeptParts.of(work, tmp_path / "kept", PARTS, batch=BATCH)
    assert again.missing() == ["2/3"]
    assert [part.document.part.number for part in again.finished()] == [1, 3]
    again.keep("2/3", {path.name: path.read_bytes() for path in (parts / "2").iterdir()})
    merge_parts(again.finished(), tmp_path / "merged", ignore)
    for name in FILES:
        assert (tmp_path / "merged" / name).read_bytes() == (parts / "whole" / name).read_bytes(), name
    with pytest.MonkeyPatch.context() as killed, pytest.raises(ZeroDivisionError):
        killed.setattr("jaxwalk.experiments.kept_parts.shutil.rmtree", lambda *_, **__: 1 / 0)
        again.remove()
    assert again.missing() == again.names, "no half part counts as finished"
    again.remove()
    assert not (tmp_path / "kept").exists()


def test_a_part_that_is_not_wanted_is_not_kept(parts, work, tmp_path):
    """Else it would stop the same command from going on with the others."""
    kept = KeptParts.of(work, tmp_path / "kept", PARTS, batch=BATCH)
    files = {number: {path.name: path.read_bytes() for path in (parts / number).iterdir()} for number in "12"}
    kept.keep("1/3", files["1"])
    with pytest.raises(PartError, match="/3: isn't what this evaluation needs there: it is part 2/3"):
        kept.keep("3/3", files["2"])
    with pytest.raises(DocumentError):  # of a worker with another jaxwalk
        kept.keep("3/3", files["1"] | {PART: b'{"format": 2}'})
    assert KeptParts.of(work, tmp_path / "kept", PARTS, batch=BATCH).missing() == ["2/3", "3/3"]
    (tmp_path / "kept" / "mine").mkdir()
    kept.remove()
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["mine"]


def test_kept_parts_of_another_evaluation_are_refused(copied, work):
    with pytest.raises(PartError, match=r"/1: isn't .*: its number of parts is 3, not 2; name another --out"):
        KeptParts.of(work, copied, 2, batch=BATCH)
    other = replace(work, scenarios=Scenarios(EPISODES, 8))
    with pytest.raises(PartError, match=r"/1: isn't what this evaluation needs there: its seed is 7, not 8; name"):
        KeptParts.of(other, copied, PARTS, batch=BATCH)
    shutil.move(copied / "3", copied / "1" / "aside")
    shutil.copytree(copied / "2", copied / "3")
    with pytest.raises(PartError, match="/3: isn't what this evaluation needs there: it is part 2/3; name another"):
        KeptParts.of(work, copied, PARTS, batch=BATCH)


def test_a_part_that_is_there_twice_and_differs_is_refused(copied):
    shutil.copytree(copied / "2", copied / "other")
    change(copied / "other", lambda document: document["cells"][0].update(sha256="0" * 64))
    with pytest.raises(PartError, match="both are part 2/3, but their rows differ; leave out one of them"):
        merged(copied, 1, 2, "other", 3)


def test_a_missing_part_is_named(copied):
    with pytest.raises(PartError, match=r"^2/3, 3/3 are missing; evaluate with --part 2/3, or name its folder too$"):
        merged(copied, 1)


CHANGES = {
    "its seed is 8, not 7": lambda document: document.update(seed=8),
    "its driver is constant-speed .policy file., not constant-speed .rule.": lambda document: document["drivers"][
        0
    ].update(kind="policy file"),
    "its maps are": lambda document: document["street"]["maps"][0].update(hash="0" * 16),
    "its world is": lambda document: document["street"]["sim"].update(pedestrians=3),
    "its options are": lambda document: document["options"].update(encounters=False),
    "its versions are": lambda document: document["made"]["versions"].update(jax="0.0.1"),
    "it was made by commit": lambda document: document["made"].update(commit="0" * 12),
    "its cells are": lambda document: document["cells"][0].update(driver_mode="sample"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_parts_of_different_evaluations_are_refused(what, copied):
    change(copied / "2", CHANGES[what])
    with pytest.raises(PartError, match=f"isn't of the same evaluation as .*: {what}.*; leave it out"):
        merged(copied, 1, 2, 3)
    assert not (copied / "merged").exists()


def test_parts_of_another_jaxwalk_are_refused(copied):
    for number in (1, 2, 3):
        change(copied / str(number), lambda document: document["made"]["versions"].update(jaxwalk="0.0.1"))
    with pytest.raises(PartError, match=r"was made by version 0\.0\.1 of jaxwalk, and this is .*; merge with the same"):
        merged(copied, 1, 2, 3)


def test_a_part_of_other_scenarios_is_refused(copied):
    change(copied / "3", lambda document: document.update(scenarios_hash="0" * 16))
    with pytest.raises(PartError, match="/3: played scenarios of hash 0000000000000000, not "):
        merged(copied, 1, 2, 3)


def test_other_processors_and_other_versions_are_told_of(copied):
    change(copied / "3", lambda document: document["made"].update(hardware="another"))
    for name in ("1", "2", "3"):
        change(copied / name, lambda document: document["made"]["versions"].update(numpy="0.1"))
    processors, versions = merged(copied, 1, 2, 3).said
    assert "the parts were played on " in processors and "another" in processors.partition(":")[0]
    assert "parts and merge have other versions (numpy 0.1, now " in versions


def test_changed_rows_are_refused(copied):
    from pyarrow import parquet

    path = copied / "2" / "outcomes.parquet"
    table = parquet.read_table(path)
    goals = table.column("goal").to_numpy()
    other = table.set_column(table.column_names.index("goal"), "goal", [~np.asarray(goals)])
    with parquet.ParquetWriter(path, other.schema) as writer:
        for first in range(0, 2 * BATCH, BATCH):
            writer.write_table(other.slice(first, BATCH))
    with pytest.raises(StoredRowsError, match="/2: its rows were changed after they were written; evaluate this part"):
        merged(copied, 1, 2, 3)


@pytest.mark.parametrize("damage", [lambda content: content[:-9], lambda _: b"", lambda content: content[:99]])
def test_damaged_rows_are_refused(damage, copied):
    path = copied / "2" / "contacts.parquet"
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(StoredRowsError, match=r"2/contacts\.parquet: damaged \(.*\); evaluate this part again"):
        merged(copied, 1, 2, 3)
    path.unlink()
    with pytest.raises(StoredRowsError, match=r"2/contacts\.parquet: can't be read \(No such file"):
        merged(copied, 1, 2, 3)


def test_a_damaged_document_is_refused(copied):
    for content, what in (("{", "no JSON"), ("[]", "of format None"), ('{"format": 2}', "damaged"), ("", "no JSON")):
        (copied / "1" / PART).write_text(content)
        with pytest.raises((PartError, DocumentError), match=what):
            read_part(copied / "1")
    (copied / "1" / PART).unlink()
    with pytest.raises(PartError, match=r"has no part\.json, so no finished part is in it"):
        read_part(copied / "1")


@pytest.mark.parametrize(("field", "value"), [("episodes", 10**9), ("batch", 0), ("dt", -1.0), ("cells", [])])
def test_impossible_numbers_of_a_document_are_refused(field, value, copied):
    change(copied / "1", lambda document: document.update({field: value}))
    error, message = (PartError, "isn't of the same evaluation") if field == "episodes" else (DocumentError, "damaged")
    with pytest.raises(error, match=message):
        merged(copied, 2, 1, 3)


def test_chunks_of_columns_have_the_sums_of_all_of_them():
    columns = {"x": np.arange(70.0), "y": np.arange(140.0).reshape(70, 2)}
    whole = statistics.episode_sums(columns, resamples=5)
    size = statistics.CHUNK
    chunks = [{name: x[first : first + size] for name, x in columns.items()} for first in range(0, 70, size)]
    in_chunks = statistics.sums_over_chunks(chunks, 70, resamples=5)
    assert all((whole[name] == in_chunks[name]).all() for name in columns)
    with pytest.raises(ValueError):
        statistics.sums_over_chunks(chunks[:-1], 70, resamples=5)


def change(folder, how):
    """Change the document of a part."""
    document = json.loads((folder / PART).read_text())
    how(document)
    (folder / PART).write_text(json.dumps(document))


def test_a_part_needs_drawn_scenarios_and_a_batch_that_divides(work, parts):
    street = work.streets[0]
    points = np.zeros((1, dimensions(street.world)), np.float32)
    kept = Archived(street, points, np.ones((1, 12), bool), 0, np.zeros(1, int))
    with pytest.raises(PartError, match="only drawn scenarios"):
        evaluate_part(replace(work, scenarios=kept), Part(1, 1), parts / "new", ignore)
    with pytest.raises(ValueError, match="batch must divide 16"):
        evaluate_part(work, Part(1, 1), parts / "new", ignore, batch=5)
    assert not (parts / "new").exists()


def test_a_stored_table_reads_what_it_is_asked_for():
    asked = []
    table = StoredTable(no_rows()[ENCOUNTERS], lambda name: asked.append(name) or np.arange(3))
    assert isinstance(table, Encounters)
    assert asked == []
    assert table.ped.tolist() == [0, 1, 2]
    assert asked == ["ped"]
    with pytest.raises(AttributeError, match="Encounters has no column pedestrian"):
        _ = table.pedestrian

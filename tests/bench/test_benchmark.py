"""The benchmark: what its figures say of rows made up by hand, and that each part can be measured."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, replace

import jax
import numpy as np
import pytest

from bench.made_up import ROWS
from jaxwalk.bench import document as documents
from jaxwalk.bench import training_speed
from jaxwalk.bench.benchmark_settings import PARTS, QUICK, Settings
from jaxwalk.bench.processes import BenchmarkError, measure_apart
from jaxwalk.bench.products import peak_products
from jaxwalk.bench.quantities import FIGURES, exponent, figures, nonlinearity
from jaxwalk.bench.showing import shown, table
from jaxwalk.bench.simulation import in_parts, keep, look_and_act
from jaxwalk.bench.starting import watch
from jaxwalk.rollout import TRAINING, environment_keys, rollout, seed_key, start

DOCUMENT = {
    "schema": 1,
    "options": asdict(Settings()),
    "hardware": {"cores": 2, "devices": 2},
    "provenance": {"commit": "abc", "hardware": "an abacus", "versions": {"jax": "0.10"}},
    "seconds": 90.0,
    "figures": figures(ROWS),
    "rows": ROWS,
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("environments", ()),
        ("environments", (64, 0)),
        ("training_environments", (-1,)),
        ("pedestrians", (0,)),
        ("seconds", -1.0),
        ("seconds", float("nan")),
        ("seed", -1),
        ("only", ()),
        ("only", ("env", "sleep")),
        ("chunk_rows", 0),
        ("suites", ("paper", "moon")),
        ("suites", ()),
        ("suite_pedestrians", (0,)),
    ],
)
def test_what_cannot_be_measured_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=f"^{name} "):
        Settings(**{name: value})


def test_quick_is_less_of_everything():
    quick, whole = Settings(**QUICK), Settings()
    assert quick.only == whole.only
    for name in ("environments", "training_environments", "pedestrians", "products", "streets"):
        assert sum(getattr(quick, name)) < sum(getattr(whole, name))
    assert set(quick.suites) < set(whole.suites)


def test_an_exponent_is_a_slope():
    x = [12, 24, 48, 96]
    assert exponent(x, [3 * n**1.7 for n in x]) == pytest.approx(1.7)
    assert exponent([12, 12], [1, 2]) is None


def test_a_line_has_no_nonlinearity():
    assert nonlinearity([64, 512, 16384], [1000 + 7 * n for n in (64, 512, 16384)]) == pytest.approx(0, abs=1e-9)
    assert nonlinearity([1, 2], [5, 9]) is None


def test_nonlinearity_is_the_largest_relative_distance():
    # by symmetry the line is flat, at a: 2 (a - 1)^2 + (a / 2 - 1)^2 is least where a = 10 / 9
    assert nonlinearity([0, 1, 2], [1, 2, 1]) == pytest.approx(4 / 9)


def test_figures_of_rows():
    found = {name: figure["value"] for name, figure in figures(ROWS).items()}
    assert found["env_steps_per_s"] == 4000
    assert found["env_steps_per_s_paper_observations"] == 5000
    assert found["env_steps_per_s_at_16384"] == 3000
    assert found["env_share_at_16384"] == 0.75
    assert found["env_temporary_memory_ratio"] == 2.0  # 300 / (100 + 50)
    assert found["memory_environments_nonlinearity"] > 0.1
    assert found["train_steps_per_s_fast"] == 40
    assert found["train_steps_per_s_fast_best"] == 50
    assert found["train_steps_per_s_fast_single_agent"] == 90
    assert found["train_steps_per_s_paper"] == 20
    assert found["agent_transitions_per_s_fast"] == 520
    assert found["peak_memory_train_fast"] == 10**9
    assert found["matmul_peak_flops"] == 1.6e8
    assert found["share_of_peak_fast"] == 0.5  # 40 x 2 MFLOP over 160 MFLOP/s
    assert found["share_of_peak_paper"] == 0.25
    assert found["best_share_of_peak_paper"] == 0.5
    assert found["first_update_warm_s"] == 4
    assert found["pedestrian_time_exponent"] == pytest.approx(1)
    assert found["pedestrian_memory_exponent"] == pytest.approx(2)
    assert found["env_share_64_streets"] == 0.5  # of the turns' 0.5, 0.9 and 0.25
    assert found["env_share_256_streets"] == 0.9  # of 0.8, 1 and 0.9
    assert found["env_share_64_streets_no_rays"] == 0.8
    assert "env_share_256_streets_no_rays" not in found
    assert found["bytes_per_street"] == 2000
    assert found["train_share_town"] == 0.6  # of 0.7, 0.6 and 0.5
    assert found["env_share_blind_corner_24"] == 0.25
    assert "env_share_paper_12" not in found


def test_what_was_not_measured_has_no_figure():
    found = figures(ROWS)
    assert not {"peak_memory_train_paper", "matmul_peak_flops_highest", "train_steps_per_s_paper_best"} & set(found)
    assert set(figures({"starts": ROWS["starts"]})) == {"import_s", "first_update_warm_s"}
    assert "share_of_peak_fast" not in figures({"training": ROWS["training"]})
    assert set(figures({"streets": ROWS["streets"][:1]})) == {"bytes_per_street"}
    assert figures({}) == {}


def test_every_figure_says_what_it_is():
    for name, figure in figures(ROWS).items():
        assert (figure["unit"], figure["what"]) == FIGURES[name]
        assert figure["what"].endswith(".")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2_345_678.4, "steps/s", "2,345,678 steps/s"),
        (0.612, "share", "61.2 %"),
        (9.61e6, "FLOP", "9.6 MFLOP"),
        (290.04e9, "FLOP/s", "290.0 GFLOP/s"),
        (1.25e9, "B", "1.2 GB"),
        (4.123, "s", "4.12 s"),
        (1.5, "exponent", "1.50"),
    ],
)
def test_figures_are_shown_for_people(value, unit, text):
    assert shown(value, unit) == text


def test_the_folder_holds_everything(tmp_path):
    documents.write(tmp_path / "there", DOCUMENT)
    names = {path.name for path in (tmp_path / "there").iterdir()}
    assert names == {"bench.json", "bench.md", "scaling.svg", "scaling.png"}
    assert json.loads((tmp_path / "there" / "bench.json").read_text()) == json.loads(json.dumps(DOCUMENT))
    page = (tmp_path / "there" / "bench.md").read_text()
    assert "| `share_of_peak_fast` | 50.0 % |" in page
    assert "| 16,384 | every | 3,000 |" in page
    assert "| blind-corner | 24 | 900 | 25.0 % [none, none] |" in page  # three turns give no interval
    assert "an abacus; commit abc; jax 0.10" in page
    assert "(scaling.svg)" in page
    assert "slope 2.00" in (tmp_path / "there" / "scaling.svg").read_text()


def test_a_part_alone_is_a_folder_too(tmp_path):
    rows = {"starts": ROWS["starts"]}
    documents.write(tmp_path, DOCUMENT | {"rows": rows, "figures": figures(rows)})
    assert {path.name for path in tmp_path.iterdir()} == {"bench.json", "bench.md"}
    assert "scaling.svg" not in (tmp_path / "bench.md").read_text()


def test_the_table_has_a_row_for_each_figure():
    assert table(DOCUMENT).row_count == len(DOCUMENT["figures"])


def test_a_document_of_parts(monkeypatch, quiet):
    """Each part in its turn; nothing is measured here."""
    asked = []

    def measured(part, settings):
        asked.append(part)
        if part == "machine":
            return {name: DOCUMENT[name] for name in ("hardware", "provenance")}
        training = [row for row in ROWS["training"] if part.endswith(row["recipe"])]
        return ROWS[part] if part in ROWS else {"rows": training, "products": ROWS["products"][:1]}

    monkeypatch.setattr(documents, "measure_apart", measured)
    monkeypatch.setattr(documents, "starts", lambda: {x["name"]: x["seconds"] for x in ROWS["starts"]})
    found = documents.benchmark(Settings(), quiet)
    assert asked == ["machine", "env", "train-fast", "train-paper", "pedestrians", "streets", "train-streets", "suites"]
    assert found["figures"].keys() == DOCUMENT["figures"].keys()
    assert set(found["rows"]) == set(ROWS)
    told = quiet.file.getvalue()
    assert f"{DOCUMENT['hardware']['devices']} devices" in told
    assert all(f"{number}/{len(PARTS)}" in told for number in range(1, 1 + len(PARTS)))
    asked.clear()
    documents.benchmark(Settings(only=("pedestrians",)), quiet)
    assert asked == ["machine", "pedestrians"]


def test_a_part_that_fails_is_named():
    with pytest.raises(BenchmarkError, match="part nothing could not be measured"):
        measure_apart("nothing", Settings())


@pytest.mark.long
def test_a_training_is_measured(tiny):
    row = training_speed.measure(tiny, 0.0)
    assert (row["environments"], row["steps"], row["updates"]) == (8, 8, 5)
    assert row["train_steps_per_s"] == pytest.approx(64 / row["update_s"])
    assert row["best_train_steps_per_s"] >= row["train_steps_per_s"]
    learning = (5 + 12 * 4) / 8  # of 8 environments stand-ins have 3 of the car's, and 4 of the people's
    assert row["agent_transitions_per_s"] == pytest.approx(learning * row["train_steps_per_s"])
    parts = row["flop_per_step_acting"] + row["flop_per_step_judging"] + sum(row["flop_per_step_fits"].values())
    assert row["flop_per_step"] == pytest.approx(parts)
    json.dumps(row, allow_nan=False)


def test_recipes_keep_their_size_unless_it_is_quick(tiny):
    assert training_speed.own_size(tiny, Settings(seed=3)) == replace(tiny, seed=3)
    assert training_speed.own_size(tiny, Settings(**QUICK)).train.environments == QUICK["recipe_environments"]
    assert training_speed.own_size(tiny, Settings(chunk_rows=64)).train.chunk_rows == 64


def test_products_are_timed():
    (row,) = peak_products((64,), 0.0)
    assert row["side"] == 64
    assert row["flops"] > 1e6


def test_a_start_is_timed_until_the_metrics_are_there(tmp_path):
    metrics = tmp_path / "metrics.jsonl"
    code = "import sys, time; open(sys.argv[1], 'w').write('{}'); time.sleep(1)"
    learned, ended = watch([sys.executable, "-c", code, str(metrics)], metrics, tmp_path / "said", {})
    assert 0 < learned < ended - 0.5


def test_a_start_that_fails_says_why(tmp_path):
    with pytest.raises(BenchmarkError, match="exit code 3: no street"):
        watch([sys.executable, "-c", "print('no street'); exit(3)"], tmp_path / "m", tmp_path / "said", {})


@pytest.mark.long
def test_parts_of_the_environments_play_what_all_of_them_would(street):
    def play(stream):
        return rollout(street, look_and_act(street), stream, 16, keep=lambda step: keep(step)[2:])

    stream = start(street, environment_keys(seed_key(3, TRAINING), 0, 6))
    whole, kept = jax.jit(play)(stream)
    parts, kept_by_parts = jax.jit(lambda stream: in_parts(play, stream, 3))(stream)
    assert jax.tree.map(np.shape, parts) == jax.tree.map(np.shape, whole)
    for one, other in zip(jax.tree.leaves((parts, kept_by_parts)), jax.tree.leaves((whole, kept)), strict=True):
        if jax.dtypes.issubdtype(one.dtype, jax.dtypes.prng_key):
            one, other = jax.random.key_data(one), jax.random.key_data(other)
        np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-4)

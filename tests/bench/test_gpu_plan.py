"""Plans for a GPU: what is read from XLA's files, what follows from it, and the refusal without a compiler."""

from __future__ import annotations

import json
import os

import pytest

from jaxwalk.bench import gpu_plan, gpu_programs
from jaxwalk.bench.benchmark_settings import Settings
from jaxwalk.bench.gpu_plan import PlanError, check_compiler, predicted, write_plan
from jaxwalk.bench.thunks import (
    COPIES,
    LAUNCHES,
    MICROSECONDS,
    SYNCHRONISATIONS,
    ThunkError,
    Work,
    by_part,
    read_work,
    total,
)
from jaxwalk.cli import main

SEQUENCE = """001: kCopy         [source       | next=002 (1)] kCopy
002: kWhile        [prev=001 (1) | sink        ]
condition:
    003: kCustomKernel [source | sink] compare
  body:
    004: kCustomKernel [source       | next=005 (1)] add
    005: kWhile        [source       | next=006 (1)]
condition:
        006: kCustomKernel [source | sink] reduce
      body:
        007: kCustomKernel [source | sink] push
        008: kCopy         [source | sink] kCopy
    011: kConditional  [prev=005 (1) | next=012 (4)]
      false_branch:
        009: kCustomKernel [source       | next=219 (1)] leg
        010: kCustomKernel [prev=218 (1) | next=220 (1)] leg
      true_branch:
        No thunks.
    012: kAsyncStart [source | sink] stream=computation_stream[0], async_id=8
        014: kDynamicSliceFusion [source | sink] params=1, results=1
            013: kCopy [source | sink] kCopy
    015: kAsyncDone    [source       | sink        ] async_id=8
"""
"""A loop of four turns; in each a kernel, a data-dependent loop of a kernel and a copy, a branch of two, and a copy."""
NAMES = {2: "while.1", 4: "add.1", 5: "while.2", 7: "push.1", 9: "leg.1", 10: "leg.2", 11: "cond.1"}
PROGRAM = """
  %while.1 = (s32[]) while(%tuple), backend_config={"known_trip_count":{"n":"4"},"known_init_step":{"init":"0"}}
  %add.1 = s32[] fusion(%p), metadata={op_name="jit(call)/jit(observe)/add"}, "cost":[{"exec_time_us":1.5,"name":""}]
  %while.2 = (s32[]) while(%tuple.1), metadata={op_name="jit(call)/while/body/jit(step)/while"}
  %push.1 = s32[] fusion(%p), metadata={op_name="jit(call)/while/body/jit(step)/add"}, "exec_time_us":2e-1,
  ROOT %leg.1 = s32[] fusion(%p), metadata={op_name="jit(call)/while/body/jit(step)/cond/add"}, "exec_time_us":0.25,
"""


@pytest.fixture
def dump(tmp_path):
    (tmp_path / "module_0001.jit_call.thunk_sequence.txt").write_text(SEQUENCE)
    metadata = "".join(f'thunk_info {{ profile_annotation: "{name}"\n thunk_id: {n} }}\n' for n, name in NAMES.items())
    (tmp_path / "module_0001.jit_call.thunk_metadata.txt").write_text(metadata)
    (tmp_path / "module_0001.jit_call.sm_9.0a_gpu_after_optimizations.txt").write_text(PROGRAM)
    return tmp_path


def test_what_runs_is_counted_turn_by_turn(dump):
    work = read_work(dump, passes=2)
    turn = 1 + (2 * 2 + 3) + 2 + 1  # a kernel; two turns and three looks at whether to go on; the longer branch; a copy
    assert total(work, LAUNCHES) == 1 + 4 * turn  # the outer loop's own condition isn't computed: its turns are known
    assert total(work, COPIES) == 1 + 4 * (2 + 1)
    assert total(work, SYNCHRONISATIONS) == 4 * (3 + 1)
    assert by_part(work, MICROSECONDS) == pytest.approx({"observe": 4 * 1.5, "step": 4 * (2 * 0.2 + 0.25)})
    assert by_part(work, LAUNCHES)["observe"] == 4


def test_without_a_pass_only_the_question_is_left(dump):
    assert total(read_work(dump, passes=0), LAUNCHES) == 1 + 4 * (1 + 1 + 2 + 1)


@pytest.mark.parametrize("ending", ["thunk_sequence.txt", "thunk_metadata.txt", "gpu_after_optimizations.txt"])
def test_files_of_another_release_are_refused(dump, ending):
    (path,) = dump.glob(f"*{ending}")
    path.unlink()
    with pytest.raises(ThunkError, match=ending):
        read_work(dump)


def test_a_sequence_in_which_nothing_is_launched_is_refused(dump):
    (path,) = dump.glob("*thunk_sequence.txt")
    path.write_text("another format\n")
    with pytest.raises(ThunkError, match="no launch"):
        read_work(dump)


ROW = {
    "program": "rollout", "recipe": "fast", "environments": 1000, "steps": 64, "pedestrians": 12,
    "launches_per_step": 100.0, "copies_per_step": 10.0, "synchronisations_per_step": 2.0,
    "microseconds_per_step": 50.0, "memory_bytes": 10**9, "compile_s": 3.0,
    "launches_by_part": {"step": 60.0, "rest": 40.0}, "microseconds_by_part": {"step": 50.0},
}  # fmt: skip


def test_speeds_follow_from_launches_waits_and_modelled_time():
    found = predicted(ROW, 4000)
    assert found["steps_per_s"] == [round(4000 / 520e-6), round(4000 / 420e-6)]  # 300 or 200, 2 x 10, 4 x 50 us
    assert found["memory_bytes"] == 4 * 10**9


def test_the_package_that_is_missing_is_named_with_the_release_of_jax(monkeypatch):
    versions = {"jax": "0.12.0.1", "jax-cuda13-plugin": "0.12.0", "jax-cuda13-pjrt": "0.12.0.1", "nvidia-nvvm": "13.0"}
    monkeypatch.setattr(gpu_plan, "_version", versions.get)
    with pytest.raises(
        PlanError, match=r"needs jax-cuda13-plugin, nvidia-cuda-nvcc, .*jax-cuda13-plugin==0\.12\.0\.1 "
    ):
        check_compiler()
    monkeypatch.setattr(gpu_plan, "_version", (versions | dict.fromkeys(gpu_plan.NEEDED, "0.12.0.1")).get)
    check_compiler()


@pytest.fixture
def compiled(monkeypatch):
    """The process that compiles is replaced by one row."""
    asked = []

    def measured(part, settings, environment):
        asked.append((part, settings, environment))
        provenance = {"commit": "abc", "hardware": "", "versions": {"jax": "1", "jaxlib": "1"}}
        return {"device": "NVIDIA H100", "provenance": provenance, "programs": [dict(ROW)]}

    monkeypatch.setattr(gpu_plan, "check_compiler", lambda: None)
    monkeypatch.setattr("jaxwalk.cli.commands.try_jax", lambda set_here: None)
    monkeypatch.setattr(gpu_plan, "measure_apart", measured)
    return asked


def test_the_command_prints_and_writes_the_plan(compiled, tmp_path, capsys):
    assert main(["bench", "--plan", "h100", "--environments", "2000", "--json", "--out", str(tmp_path / "new")]) == 0
    out = capsys.readouterr().out
    assert (tmp_path / "new" / "plan.json").read_text() == out
    document = json.loads(out)
    assert [x["environments"] for x in document["predictions"]] == [2000]
    ((part, settings, environment),) = compiled
    assert (part, settings.plan, environment["JAX_PLATFORMS"]) == ("plan", "h100", "cpu")


def test_the_tables_say_that_nothing_was_measured(compiled, capsys):
    assert main(["bench", "--plan", "h100"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Predicted, not measured" in said
    assert "65,536" in said
    assert "100.00" in said


@pytest.fixture
def machine(monkeypatch):
    """A machine with a GPU, on which one program was measured; a test may take the GPU out."""
    seen = {"platform": "gpu"}
    monkeypatch.setattr("jaxwalk.cli.commands.try_jax", lambda set_here: None)

    def measured(part, settings, environment=None):
        if part == "machine":
            return {"hardware": seen}
        assert environment == {"JAX_ENABLE_COMPILATION_CACHE": "false", "JAX_DISABLE_MOST_OPTIMIZATIONS": "false"}
        provenance = {"commit": "abc", "hardware": "", "versions": {"jax": "1", "jaxlib": "1"}}
        rows = [ROW | {"environments": n, "measured_steps_per_s": 7 * n} for n in settings.environments]
        return {"device": "NVIDIA H100", "provenance": provenance, "programs": rows}

    monkeypatch.setattr(gpu_plan, "measure_apart", measured)
    return seen


def test_on_a_gpu_of_this_machine_the_measured_speed_stands_beside_the_predicted_one(machine, capsys):
    assert main(["bench", "--plan", "here", "--environments", "1000", "3000", "--seconds", "1", "--json"]) == 0
    predictions = json.loads(capsys.readouterr().out)["predictions"]
    assert [(x["environments"], x["measured_steps_per_s"]) for x in predictions] == [(1000, 7000), (3000, 21000)]
    assert main(["bench", "--plan", "here", "--environments", "3000"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "measured steps/s" in said
    assert "21,000" in said
    assert "not measured" not in said


def test_without_a_gpu_its_programs_are_not_measured(machine, capsys):
    machine["platform"] = "cpu"
    assert main(["bench", "--plan", "here"]) == 2
    assert "JAX sees none (only: cpu); install jaxwalk[cuda]" in " ".join(capsys.readouterr().err.split())


@pytest.mark.long
def test_programs_are_compiled_together_and_each_is_timed(monkeypatch):
    monkeypatch.setattr(gpu_programs, "read_work", lambda folder: Work({(LAUNCHES, "step"): 640}))  # a CPU's has none
    rows = gpu_programs.plan(Settings(quick=True, plan="here", environments=(4, 8), seconds=0.01))["programs"]
    assert [row["environments"] for row in rows] == [4, 8]
    assert [row["launches_per_step"] for row in rows] == [10, 10]
    assert all(row["measured_steps_per_s"] > 0 for row in rows)


def test_calls_go_on_from_each_other_until_the_time_is_over(monkeypatch):
    clock = iter(range(100))
    monkeypatch.setattr(gpu_programs.time, "perf_counter", lambda: float(next(clock)))
    states = []

    def call(state, street):
        states.append(state)
        return state + street, None

    assert gpu_programs.call_time(call, (3, 2), seconds=7.0) == 1.0  # a call lasts one tick of that clock
    assert states == [3, 5, 7, 9, 11, 13, 15, 17]  # one that isn't timed, and seven


def test_a_disk_that_is_full_leaves_nothing(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="space"):
        write_plan(tmp_path / "out", "{}")
    assert not list((tmp_path / "out").glob("plan*"))

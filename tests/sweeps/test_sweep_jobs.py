"""Processes elsewhere: submitit's executors in place of SLURM, and a cluster of Ray on this machine."""

from __future__ import annotations

import json

import pytest

from jaxwalk.cli import main, sweep_jobs
from jaxwalk.cli.sweep_jobs import SweepJob, submit_jobs
from jaxwalk.experiments.on_ray import ClusterError
from sweeps.tiny_sweep import written

WRONG = {
    "--workers 2": "--workers goes with --on slurm or ray; here, run the same command several times",
    "--on ray --workers 0": "--workers must lie in [1, 10,000], not 0",
    "--on ray --slurm timeout_min=3": "--slurm goes with --on slurm",
}


@pytest.mark.parametrize("words", WRONG)
def test_options_that_make_no_sense_are_refused(words, study, tmp_path, capsys):
    assert main(["sweep", str(study()), "--out", str(tmp_path / "out"), *words.split()]) == 2
    assert WRONG[words] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("package", ["submitit", "ray"])
def test_a_missing_package_is_named_with_its_extra(package, study, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sweep_jobs.importlib.util, "find_spec", lambda name: None if name == package else object())
    on, extra = ("slurm", "sweep") if package == "submitit" else ("ray", "cluster")
    assert main(["sweep", str(study()), "--out", str(tmp_path / "out"), "--on", on]) == 2
    assert f'install it with: pip install "jaxwalk[{extra}]"' in capsys.readouterr().err


def test_where_there_is_no_slurm_nothing_is_submitted(study, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["sweep", str(study()), "--out", str(tmp_path / "out"), "--on", "slurm"]) == 2
    assert "--on slurm: there is no srun on this machine" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("timeout_min", "write KEY=VALUE"),
        ("slurm_nonsense=3", "--slurm: Unknown argument 'nonsense'"),
        ("timeout_min=long", '--slurm: Parameter "timeout_min" expected type'),
        ("timeout_min=", "write KEY=VALUE"),
    ],
)
def test_a_wrong_parameter_is_refused(word, said, pretended, study, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sweep_jobs, "CLUSTER", "debug")
    line = ["sweep", str(study()), "--out", str(tmp_path / "out"), "--on", "slurm", "--slurm", word]
    assert main(line) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_submitted_jobs_work_on_the_trials(pretended, study, tmp_path, capsys, monkeypatch):
    """With submitit's debug executor, whose jobs stay in this process."""
    jobs = []
    monkeypatch.setattr(sweep_jobs, "CLUSTER", "debug")
    monkeypatch.setattr("jaxwalk.cli.sweep.submit_jobs", lambda options: jobs.extend(submit_jobs(options)) or jobs)
    monkeypatch.setenv("JAX_NUM_CPU_DEVICES", "2")
    monkeypatch.chdir(tmp_path)
    line = [*["sweep", "study.toml", "--out", "out", "--on", "slurm", "--workers", "2", "--slurm", "timeout_min=5"]]
    study()
    assert main(line) == 0
    assert capsys.readouterr().out.startswith("Submitted to SLURM: ") and len(jobs) == 2
    assert not pretended.trained and (tmp_path / "out" / "plan.json").is_file()
    assert jobs[0].submission().function == SweepJob(tmp_path / "study.toml", tmp_path / "out", 2)
    assert [job.submission().function() for job in jobs] == [0, 0]
    assert [number for number, _, _ in pretended.trained] == ["0", "1", "2", "3"]
    assert json.loads((tmp_path / "out" / "study.json").read_text())["best"]


def test_what_no_machine_of_a_cluster_has_is_refused():
    """Ray would wait for it for ever."""
    nodes = [{"Alive": True, "Resources": {"CPU": 4.0}}, {"Alive": False, "Resources": {"CPU": 64.0, "GPU": 1.0}}]
    sweep_jobs._check_room(nodes, "--cpus", "CPU", 4)
    sweep_jobs._check_room(nodes, "--gpus", "GPU", 0)
    with pytest.raises(ClusterError, match=r"--cpus 8: no machine of the cluster has that many; the largest has 4"):
        sweep_jobs._check_room(nodes, "--cpus", "CPU", 8)
    with pytest.raises(ClusterError, match=r"--gpus 1: .* has 0"):
        sweep_jobs._check_room(nodes, "--gpus", "GPU", 1)


def test_a_job_that_is_ended_before_its_time_is_submitted_again(study, tmp_path):
    job = SweepJob(study(), tmp_path / "out", 2)
    assert job.checkpoint().function == job


def complete(folder, count):
    """Whether each trial of a sweep is complete, and in the journal once."""
    document = json.loads((folder / "study.json").read_text())
    ended = [json.loads(line) for line in (folder / "journal.log").read_text().splitlines()]
    numbers = [entry["trial_id"] for entry in ended if entry["op_code"] == 6 and entry["state"] == 1]
    states = [trial["state"] for trial in document["trials"]]
    return states == ["complete"] * count and sorted(numbers) == list(range(count))


@pytest.mark.long
def test_jobs_of_submitits_local_executor_complete_a_sweep(place, monkeypatch):
    """Two real processes, as on SLURM each with a log, and tiny trainings."""
    jobs = []
    monkeypatch.setattr(sweep_jobs, "CLUSTER", "local")
    monkeypatch.setattr("jaxwalk.cli.sweep.submit_jobs", lambda options: jobs.extend(submit_jobs(options)) or jobs)
    study = written(place, trials=4)
    line = ["sweep", str(study), "--out", "out", "--on", "slurm", "--workers", "2", "--cpus", "1"]
    assert main([*line, "--slurm", "timeout_min=30"]) == 0
    assert [job.result() for job in jobs] == [0, 0]
    assert complete(place / "out", 4)
    assert len(list((place / "out" / "jobs").glob("*_log.err"))) == 2


@pytest.mark.long
@pytest.mark.filterwarnings("default")  # those of Ray are its own
@pytest.mark.usefixtures("lenient_processes")
def test_tasks_on_two_nodes_of_ray_complete_a_sweep(place, monkeypatch):
    """Ray's test cluster: two nodes of one core each on the loopback address, and a task on each."""
    pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    try:
        cluster.add_node(num_cpus=1)
        monkeypatch.setenv("RAY_ADDRESS", cluster.address)
        study = written(place, trials=4)
        assert main(["sweep", str(study), "--out", "out", "--on", "ray", "--workers", "2", "--cpus", "1"]) == 0
    finally:
        cluster.shutdown()
    assert complete(place / "out", 4)

"""Rows of a benchmark, made up by hand."""

from __future__ import annotations


def _simulated(environments, rate, temporary, pedestrians=12, observations="every"):
    return {
        "environments": environments, "pedestrians": pedestrians, "env_steps_per_s": rate, "observations": observations,
        "best_env_steps_per_s": rate, "compile_s": 1.0,
        "temporary_bytes": temporary, "state_bytes": 100 * environments, "kept_bytes": 50 * environments,
    }  # fmt: skip


def _trained(recipe, environments, rate, *, single_agent=False):
    return {
        "recipe": recipe, "single_agent": single_agent, "environments": environments, "steps": 4,
        "train_steps_per_s": rate, "best_train_steps_per_s": 2 * rate,
        "agent_transitions_per_s": 13.0 * rate, "flop_per_step": 2e6, "flops": 2e6 * rate,
        "first_update_s": 5.0,
    }  # fmt: skip


ROWS = {
    "env": [
        _simulated(64, 1000, 64 * 75),
        _simulated(512, 4000, 512 * 300),
        _simulated(16384, 3000, 16384 * 75),
        _simulated(512, 5000, 512 * 900, observations="paper"),
    ],
    "training": [
        _trained("fast", 512, 40.0) | {"peak_memory_bytes": 10**9},
        _trained("fast", 512, 90.0, single_agent=True),
        _trained("fast", 2048, 50.0),
        _trained("paper", 512, 20.0),
    ],
    "products": [
        {"side": 512, "precision": "default", "flops": 1e8},
        {"side": 1024, "precision": "default", "flops": 1.6e8},
        {"side": 1024, "precision": "default", "flops": 1.5e8},
    ],
    "starts": [{"name": "import_s", "seconds": 0.2}, {"name": "first_update_warm_s", "seconds": 4.0}],
    "pedestrians": [_simulated(256, 4000, 256, 12), _simulated(256, 2000, 1024, 24), _simulated(256, 1000, 4096, 48)],
    "streets": [
        {"observations": seen, "streets": n, "environments": 64, "env_steps_per_s": speeds, "bytes_per_street": size}
        for seen, n, speeds, size in (
            ("every", 1, [100.0, 10.0, 40.0], 900),
            ("every", 64, [50.0, 9.0, 10.0], 2000),
            ("every", 256, [40.0, 9.0, 9.0], 1000),
            ("no rays", 1, [100.0, 100.0, 100.0], 900),
            ("no rays", 64, [80.0, 90.0, 70.0], 2000),
        )
    ],
    "train-streets": [
        {"recipe": "fast", "train_steps_per_s": [10.0, 2.0, 8.0]},
        {"recipe": "town", "train_steps_per_s": [7.0, 1.2, 4.0]},
    ],
    "suites": [
        {"suite": suite, "pedestrians": people, "env_steps_per_s": speeds, "share_of_paper": shares}
        for suite, people, speeds, shares in (
            ("paper", 12, [1000.0, 2000.0, 4000.0], [1.0, 1.0, 1.0]),
            ("blind-corner", 24, [200.0, 900.0, 1000.0], [0.2, 0.45, 0.25]),
        )
    ],
}

"""A sweep of trainings so small that their time is all compiling; what varies compiles nothing anew."""

from __future__ import annotations

from pathlib import Path

TINY = """
sampler = "{sampler}"
{trials}

[objective]
metric = "{metric}"
direction = "maximise"
{more}

[training.train]
environments = 8
steps = 8
minibatches = 2
updates = {updates}

[training.train.roles.driver]
actor_hidden = [8]
critic_hidden = [8]
epochs = 1

[training.train.roles.pedestrian]
actor_hidden = [8]
critic_hidden = [8]
epochs = 1

[vary.driver_weights]
time = {{ low = -0.25, high = -0.02 }}
"""


def written(folder: Path, **changes) -> Path:
    usual = {"sampler": "random", "trials": 2, "metric": "reward/driver", "more": "", "updates": 1}
    found = usual | changes
    found["trials"] = f"trials = {found['trials']}" if found["sampler"] != "pbt" else ""
    (folder / "study.toml").write_text(TINY.format(**found))
    return folder / "study.toml"

"""A sweep of four short trainings: which price of time makes the car collect most reward for its progress?

Needs ``pip install "jaxwalk[sweep]"``. On the command line: ``jaxwalk sweep study.toml``; docs/sweeps.md says what the
file holds.
"""

from pathlib import Path

from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweeping import sweep

STUDY = """
sampler = "grid"

[objective]
metric = "reward/driver/progress"
direction = "maximise"

[training.train]
environments = 64
steps = 32
minibatches = 4
updates = 4                        # use some hundreds

[vary.driver_weights]
time = { low = -0.25, high = -0.02, points = 4 }
"""

path = Path("study.toml")
path.write_text(STUDY)
results = sweep(Path("sweep"), load_sweep(path))
print(results.in_words())
for trial in results.best:
    print(f"trial {trial.number}: {trial.value:.4f}, {dict(trial.values)}, in sweep/trials/{trial.number}/seed-0")
again = sweep(Path("sweep"), load_sweep(path))  # nothing is left to do
assert again.best == results.best and Path("sweep/study.html").is_file()

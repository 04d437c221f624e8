# Needs python3 (3.11 or newer, with venv and pip) and make; `make` alone lists the targets.

PYTHON ?= python3
JOBS ?= $(shell $(PYTHON) -c 'import os; print(min(os.cpu_count() or 1, 8))')

VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
UV := $(shell command -v uv 2>/dev/null || echo $(BIN)/uv)

# Hundreds of processes start in the tests: what they import is compiled once.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help install check lint types contracts test coverage mutants reliability speed versions format reproduce evidence pictures docs bench \
	wheel lock clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

install: $(INSTALLED)  ## make .venv and install the pinned dependencies and jaxwalk itself (editable)

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "jaxwalk needs Python 3.11 or newer, and '$(PYTHON)' is not one: name one, as in 'make install PYTHON=python3.12'" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(BIN)/uv: | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv

$(INSTALLED): pyproject.toml requirements/core.txt requirements/dev.txt | $(BIN)/python $(UV)
	$(UV) pip install --quiet --compile-bytecode --python $(BIN)/python -r requirements/dev.txt
	$(UV) pip install --quiet --python $(BIN)/python --no-deps --editable .
	@touch $@

check: lint types contracts  ## lint, types and contracts

lint: install  ## ruff: mistakes, docstrings, layout
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: install  ## pyright
	$(BIN)/pyright

contracts: install  ## import-linter: which room may import which
	$(BIN)/lint-imports --no-logo --no-cache

test: install  ## pytest, in JOBS processes (default: one for each core, at most 8)
	$(BIN)/pytest -n $(JOBS)

coverage: install  ## the same and the long tests, and which lines and branches they reached
	$(BIN)/pytest -n $(JOBS) -m "long or not long" --cov --cov-fail-under=95

mutants: install  ## small mistakes are put into the definitions: do the tests notice? some six hours
	$(UV) pip install --quiet --python $(BIN)/python --constraint requirements/dev.txt cosmic-ray==8.7.0
	$(BIN)/python tests/reliability/mutation.py

reliability: install  ## thousands of bad files and policies, faults, millions of random steps, trainings killed 50 times, 0.1's behaviour again: some hours
	$(UV) pip install --quiet --python $(BIN)/python --constraint requirements/dev.txt -r pyproject.toml --extra cluster
	$(BIN)/pytest -n $(JOBS) -m long
	$(BIN)/python tests/reliability/coverage.py
	$(BIN)/python tests/reliability/fuzz_loaders.py
	$(BIN)/python tests/reliability/fuzz_weights.py
	$(BIN)/python tests/reliability/faults.py
	$(BIN)/python tests/reliability/random_steps.py
	$(BIN)/python tests/reliability/kill_training.py --kills 50
	$(BIN)/python tests/compat/compare.py

speed: install  ## this checkout's speed against that of the checkout OLD (with its own .venv): half an hour on a quiet machine
	$(BIN)/python tests/reliability/speed_against.py $(OLD)

versions: | $(UV)  ## the tests with the oldest and the newest allowed releases, on Python 3.11 and 3.14: 40 minutes
	UV=$(UV) .ci/versions -n $(JOBS)

format: install  ## let ruff tidy the code
	$(BIN)/ruff check --fix-only
	$(BIN)/ruff format

reproduce: install  ## the paper's tables and figures again, into runs/reproduce
	$(BIN)/jaxwalk reproduce --out runs/reproduce

evidence: install  ## the whole suite for the shipped drivers and the rules, into runs/evidence: up to 45 minutes
	$(BIN)/jaxwalk evaluate --suite paper-footprint --driver random constant-speed rule-based rule-based-braking route-follower \
	  clearance single-agent co-trained --pedestrians always-go learned gap-acceptance --episodes 10000 --seed 51 \
	  --counterfactuals 200 --encounters --out runs/evidence

# The scenario is one in which the co-trained car lets a jaywalker pass.
EPISODE = --driver co-trained --pedestrians learned --scenario 17

pictures: install  ## the pictures of README and docs, and an animation for talks: needs Chromium
	$(BIN)/jaxwalk play $(EPISODE) --time 4 --out docs/images/episode.png
	$(BIN)/jaxwalk play $(EPISODE) --out docs/images/episode.gif
	$(BIN)/jaxwalk play --suite crowd --driver town --scenario 3 --time 6 --out docs/images/crowd.png
	$(BIN)/jaxwalk play --suite blind-corner --driver clearance --scenario 3 --time 6 --out docs/images/blind-corner.png
	$(BIN)/jaxwalk report --out runs/report
	$(BIN)/python docs/screenshots.py runs/report/report.html docs/images
	$(BIN)/python docs/live_screenshot.py docs/images

docs: install  ## the site, into build/site: pages, the reference from the code, links checked
	$(UV) pip install --quiet --python $(BIN)/python -r requirements/docs.txt
	$(BIN)/python docs/website/build.py

bench: install  ## how fast simulator and training are on this machine: some minutes
	$(BIN)/jaxwalk bench

wheel: install  ## build dist/*.whl
	rm -rf dist
	$(UV) build --quiet --wheel --out-dir dist

# The others are held to what dev chose, so that the lists always agree. No list names a package index.
COMPILE = $(UV) pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --no-emit-find-links \
	--no-annotate --custom-compile-command 'make lock' pyproject.toml

lock: | $(UV)  ## choose the newest versions anew and pin them in requirements/
	$(COMPILE) --upgrade --extra dev -o requirements/dev.txt
	$(COMPILE) --upgrade --constraint requirements/dev.txt -o requirements/core.txt
	$(COMPILE) --upgrade --constraint requirements/dev.txt --extra docs -o requirements/docs.txt
	$(COMPILE) --upgrade --constraint requirements/dev.txt --extra cluster -o requirements/cluster.txt

clean:  ## remove what was built and cached; .venv and runs stay
	rm -rf build dist site .pytest_cache .ruff_cache .hypothesis htmlcov .coverage*
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

# `make demo` and `make test` set up everything they need; they require Python 3.11 or newer and pip.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

PARALLEL := --numprocesses auto --maxprocesses 4 --dist loadfile

# A browser for the tests of the page, where there is none and we may install one.
HAS_BROWSER := command -v chromium || command -v chromium-browser || command -v google-chrome

.PHONY: demo test quick elsewhere mutants damaged bench speed evaluation experiment docs clean

demo: $(VENV)/.core
	$(BIN)/hognose demo

test: $(VENV)/.all $(VENV)/.browser
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
# Types leave a core idle.
	$(BIN)/python -m tests.compile_kernels & $(BIN)/basedpyright && $(BIN)/python -m tests.compile_kernels backwards && wait
	$(BIN)/pytest $(PARALLEL)

# What is computed, without what draws, searches, runs commands, browses, moves drives or reads files.
COMPUTED := tests/robot tests/path tests/mechanics tests/following tests/scene/test_scene_distance.py \
  tests/planning/test_certificate.py tests/planning/test_checks.py tests/planning/test_bundled_plans.py
quick: $(VENV)/.all
	$(BIN)/pytest -m "not slow" $(COMPUTED) --ignore=tests/following/test_fitted.py $(PARALLEL)

# Mistakes that the tests must notice, one after another: tests/mutants.toml.
mutants: $(VENV)/.all
	$(BIN)/python tests/mutants.py

# 10,000 damaged files of all formats: no crash, no traceback, nothing dropped silently.
damaged: $(VENV)/.all
	$(BIN)/python tests/scene/damaged_files.py

# `make test` as on another processor, with another BLAS and kernels for a generic one; then what must be the same on
# this one and all others.
elsewhere: export OPENBLAS_CORETYPE := Nehalem
elsewhere: export NUMBA_CPU_NAME := generic
elsewhere: test
	$(BIN)/python -m benchmarks.machines

bench: $(VENV)/.all
	$(BIN)/python -m benchmarks

# The tables of docs/speed.md; those of routes and arms take hours and have commands of their own, which the page names.
speed: $(VENV)/.all $(VENV)/.browser
	$(BIN)/python -m benchmarks --docs docs/speed.md
	$(BIN)/python -m benchmarks.as_it_stands --docs docs/speed.md
	$(BIN)/python -m benchmarks.viewer --docs docs/speed.md

evaluation: $(VENV)/.all
	$(BIN)/hognose bench --fresh --docs docs/evaluation.md

experiment: $(VENV)/.all
	$(BIN)/python -m benchmarks.experiment --docs docs/experiment.md
	$(BIN)/python -m benchmarks.whole_experiment --docs docs/experiment.md

docs: $(VENV)/.all
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html

clean:
	rm -rf $(VENV) hognose-demo hognose-bench docs/_build build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests benchmarks docs -name __pycache__ -prune -exec rm -rf {} +

$(BIN)/python:
	$(PYTHON) -m venv $(VENV) || ($(PYTHON) -m pip install virtualenv && $(PYTHON) -m virtualenv $(VENV))

$(VENV)/.browser: | $(BIN)/python
	$(HAS_BROWSER) || (apt-get update -qq && apt-get install -y -qq chromium) || \
	  (echo "The tests of the page need Chromium: install it, then make test again."; exit 1)
	touch $@

$(VENV)/.core: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[step]'
	touch $@

$(VENV)/.all: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test,lint,docs,step,view,drive,ros,bench]'
	touch $@ $(VENV)/.core

# `make demo` and `make test` set everything up by themselves; they need Python 3.11 or newer and pip.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# Files whose compiled functions other files call: numba does not notice there when they change.
SHARED_KERNELS := $(addprefix src/hognose/, path/polynomial.py \
  $(addprefix following/, crossing.py chain.py fabrik.py least_squares.py))

# A browser for the tests of the page, where there is none and we may install one.
HAS_BROWSER := command -v chromium || command -v chromium-browser || command -v google-chrome

.PHONY: demo test bench evaluation docs clean

demo: $(VENV)/.core $(VENV)/.kernels
	$(BIN)/hognose demo

test: $(VENV)/.all $(VENV)/.kernels $(VENV)/.browser
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/basedpyright
	$(BIN)/pytest

bench: $(VENV)/.all $(VENV)/.kernels
	$(BIN)/python -m benchmarks

evaluation: $(VENV)/.all $(VENV)/.kernels
	$(BIN)/hognose bench --fresh --docs docs/evaluation.md

docs: $(VENV)/.all
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html

clean:
	rm -rf $(VENV) hognose-demo hognose-bench docs/_build build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests benchmarks docs -name __pycache__ -prune -exec rm -rf {} +

$(BIN)/python:
	$(PYTHON) -m venv $(VENV) || ($(PYTHON) -m pip install virtualenv && $(PYTHON) -m virtualenv $(VENV))

$(VENV)/.kernels: $(SHARED_KERNELS) | $(BIN)/python
	find src -name '*.nb[ic]' -delete
	touch $@

$(VENV)/.browser: | $(BIN)/python
	$(HAS_BROWSER) || (apt-get update -qq && apt-get install -y -qq chromium) || \
	  (echo "The tests of the page need Chromium: install it, then make test again."; exit 1)
	touch $@

$(VENV)/.core: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[step]'
	touch $@

$(VENV)/.all: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test,lint,docs,step,view,bench]'
	touch $@ $(VENV)/.core

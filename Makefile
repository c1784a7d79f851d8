# `make demo` and `make test` set everything up by themselves in a private .venv; python3 >= 3.11 is all they need.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test bench venv clean

demo: venv  ## run the main job; options by e.g. make demo OPTIONS="--duration 20 --errors bias"
	$(BIN)/python -m experiments.moving_team $(OPTIONS)

test: venv  ## lint, types, tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest --numprocesses auto

bench: venv  ## one projection by several ways, side by side; options as for the demo
	$(BIN)/python -m experiments.benchmark $(OPTIONS)

venv: .venv/ready

.venv/ready: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or later is needed; try make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	$(BIN)/python -m experiments.warm_up
	@touch $@

clean:
	rm -rf .venv runs filter/__pycache__

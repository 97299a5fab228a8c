# Two commands, each sufficient by itself on a bare clone:
#   make run     the live hand in the browser (Ctrl-C stops it)
#   make test    linters, type checker, import contracts, all tests
# Needs make and Python 3.11 to 3.13 with venv. Another Python: make run PYTHON=/path/to/python3.12

PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	"$$p" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 14))' 2>/dev/null && echo "$$p" && break; done)
VENV ?= .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: run test lint bench soak wheel clean
.DEFAULT_GOAL := run

run: $(VENV)/run.stamp
	$(BIN)/handlab run

test: lint
	$(BIN)/python -m pytest -n 2 --dist loadgroup

lint: $(VENV)/test.stamp
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/test.stamp
	$(BIN)/python benchmarks/run.py

# One hour of simulated time under random contraction; the test command runs a minute of it.
soak: $(VENV)/test.stamp
	$(BIN)/python -m tools.soak

wheel: $(VENV)/test.stamp
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .

clean:
	rm -rf "$(VENV)" dist handlab-pictures

$(VENV)/created.stamp:
	@test -n "$(PYTHON)" || { echo "No Python 3.11, 3.12 or 3.13 found. Install one, or say which: make run PYTHON=/path/to/python3.12"; exit 1; }
	@rm -rf "$(VENV)"
	@"$(PYTHON)" -m venv "$(VENV)" || { rm -rf "$(VENV)"; \
	  if command -v uv >/dev/null; then echo "python -m venv failed; trying uv"; uv venv --quiet --seed --python "$(PYTHON)" "$(VENV)"; \
	  else echo "Python has no ensurepip. On Debian or Ubuntu: sudo apt-get install python3-venv   (or install uv)"; exit 1; fi; }
	@touch $@

$(VENV)/run.stamp: $(VENV)/created.stamp pyproject.toml constraints.txt
	@echo "Installing handlab into $(VENV) (once, about a minute) ..."
	@$(INSTALL) --editable .
	@touch $@

$(VENV)/test.stamp: $(VENV)/created.stamp pyproject.toml constraints.txt
	@echo "Installing handlab and what its tests need into $(VENV) (once, about a minute) ..."
	@$(INSTALL) --editable ".[lab,test,dev]"
	@touch $@

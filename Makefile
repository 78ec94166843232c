# Two commands: `make demo` and `make test`. Both make their own virtual environment in .venv.
VENV := .venv
BIN := $(VENV)/bin
# Of the Python that `python3` is, or of another: `make test PYTHON=python3.12`. One that was compiled without
# `--enable-optimizations` takes the tests 8 to 22 % longer: the system's, of the same 3.x and with venv, goes before it.
SYSTEM := /usr/bin/python3
VERSION := print(sys.implementation.name, *sys.version_info[:2])
SYSTEMS := import ensurepip, sys; $(VERSION)
OWN := import sys, sysconfig; "--enable-optimizations" in str(sysconfig.get_config_var("CONFIG_ARGS")) or $(VERSION)
PYTHON ?= $(shell { [ "$$($(SYSTEM) -c '$(SYSTEMS)' || echo none)" = "$$(python3 -c '$(OWN)')" ]; } 2> /dev/null \
	&& echo $(SYSTEM) || echo python3)

.PHONY: demo install web test lint types contracts tests slowest test-postgres proof docs dist clean

demo: install
	$(BIN)/station demo

install: $(VENV)/.installed
# one after the other, also under `make -j`: mypy once read a cut file beside two other jobs
test: $(VENV)/.installed-test
	$(MAKE) --jobs 1 lint types contracts tests

PIP := $(BIN)/python -m pip install --disable-pip-version-check --constraint constraints.txt --editable

$(VENV)/bin/python:
	@echo "== a virtual environment in $(VENV), of $(PYTHON): some seconds"
	$(PYTHON) -m venv $(VENV) || { rm -f $@; exit 1; }

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml constraints.txt
	@echo "== the station and the libraries that it stands on, about 70: a minute, by the line"
	$(PIP) .
	@echo "== its numerical kernels, compiled for this machine once: half a minute"
	$(BIN)/python -m procedures.attitude.attitude_estimate
	$(BIN)/python -m station.calibrated.applied_calibration
	touch $@

$(VENV)/.installed-test: $(VENV)/.installed pyproject.toml constraints.txt
	@echo "== what the tests need, about 80 libraries more: a minute"
	$(PIP) ".[test,peers]"
	touch $@

# What one extra of pyproject.toml needs: `make extra-camera`, `make extra-pdf`; `make web` is short for `make extra-web`.
extra-%: install
	$(PIP) ".[$*]"
web: extra-web

# Words that nobody must meet in texts and names, with what stands for them. Kept: keys and flags that version 1 promises,
# and former commands of the simulated hands.
KEPT := begun anew|unnoticed leans|lean arcsec|calibration doubted| (wander|cannot tell|is told)$$|`lean` and `knock`
DIALECT := --dictionary tests/dialect.txt --ignore-regex '^\S+:\d+:|$(KEPT)'
lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m tests.docstring_check
	$(BIN)/python -m tests.user_text | $(BIN)/codespell $(DIALECT) - README.md docs/*.md docs/[ceht]*/[!R]*.md docs/reference/effects.md
	$(BIN)/python -m tests.code_names | $(BIN)/codespell $(DIALECT) -

types:
	$(BIN)/mypy

contracts:
	$(BIN)/lint-imports

# One worker more than processors: some tests wait for devices.
WORKERS := $(shell expr $$(nproc) + 1)
tests:
	$(BIN)/python -m tests.with_postgres $(BIN)/pytest -n $(WORKERS) --dist loadfile

# The same tests, one after the other, and the thirty that take longest.
slowest: $(VENV)/.installed-test
	$(BIN)/python -m tests.with_postgres $(BIN)/pytest -n 0 -q --durations=30 --durations-min=0

# The database's tests on a temporary PostgreSQL server; `make tests` includes them where its binaries are.
test-postgres: $(VENV)/.installed-test
	$(BIN)/python -m tests.with_postgres --require $(BIN)/pytest tests/fixtures_db

# The long statistical runs, hours; `make proof ONLY="kills coverage"` makes these alone, into docs/evidence.
proof: $(VENV)/.installed-test
	$(BIN)/python -m tests.with_postgres $(BIN)/python -m tests.proof $(or $(ONLY),--all)

# The documentation as a site, in the folder site. A warning is an error: mkdocs.yml says so.
docs: $(VENV)/.installed-docs
	$(BIN)/python docs/generate.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

$(VENV)/.installed-docs: $(VENV)/.installed
	$(PIP) ".[docs]"
	touch $@

# The source distribution and the wheel; the wheel is installed into an empty environment and runs the demo there.
dist: $(VENV)/bin/python
	rm -rf dist
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --constraint constraints.txt build
	$(BIN)/python -m build --outdir dist
	$(PYTHON) -m venv dist/empty
	dist/empty/bin/python -m pip install --disable-pip-version-check --quiet --constraint constraints.txt dist/*.whl
	cd dist && empty/bin/station demo --out demo
	rm -rf dist/empty dist/demo

clean:
	rm -rf $(VENV) build dist site

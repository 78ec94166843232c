# Two commands: `make demo` and `make test`. Both make their own virtual environment in .venv.
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo install web test lint types contracts tests slowest test-postgres benchmark clean

demo: install
	$(BIN)/station demo

install: $(VENV)/.installed
test: $(VENV)/.installed-test lint types contracts tests

$(VENV)/bin/python:
	python3 -m venv $(VENV)

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	$(BIN)/python -c "import procedures.counts.count_kernels; from procedures.attitude.compile_kernels import compile_all; compile_all()"
	touch $@

$(VENV)/.installed-test: $(VENV)/.installed pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[test,peers]"
	touch $@

# What `station calibrate --web` needs.
web: install
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[web]"

lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m tests.docstring_check

types:
	$(BIN)/mypy

contracts:
	$(BIN)/lint-imports

tests:
	$(BIN)/python -m tests.with_postgres $(BIN)/pytest -n auto

# The same tests, one after the other, and the thirty that take longest.
slowest: $(VENV)/.installed-test
	$(BIN)/python -m tests.with_postgres $(BIN)/pytest -n 0 -q --durations=30 --durations-min=0

# The database's tests on a temporary PostgreSQL server; `make tests` includes them where its binaries are.
test-postgres: $(VENV)/.installed-test
	$(BIN)/python -m tests.with_postgres --require $(BIN)/pytest tests/fixtures_db

benchmark: $(VENV)/.installed-test
	$(BIN)/python -m tests.benchmarks

clean:
	rm -rf $(VENV)

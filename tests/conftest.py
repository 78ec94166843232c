"""One thread of OpenBLAS a process, as `station` has it; tables that must be whole before any test runs."""

import os
import traceback
from importlib import import_module

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before a test module loads numpy

TABLES = ("drivers.wire", "drivers.simulated.effects", "procedures.effects")


def pytest_configure() -> None:
    """Say in one sentence what an entry of a table lacks: it would else be an error of every file of tests."""
    for table in TABLES:
        try:
            import_module(table)
        except Exception as error:
            entry = traceback.extract_tb(error.__traceback__)[-1]
            raise pytest.UsageError(f"{entry.filename}, line {entry.lineno}: {error}") from error

"""`station apply` run in this process, and what it wrote read back."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from typer.testing import CliRunner, Result

from station.cli import app
from station.errors import DataRefused, explain

OUTPUTS = [f"{name}_{axis}_{unit}" for name, unit in (("f", "m_s2"), ("omega", "rad_s")) for axis in "xyz"]


def apply(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["apply", *map(str, arguments)])


def written(path: Path) -> np.ndarray:
    with np.load(path) as arrays:
        return np.column_stack([arrays[name] for name in OUTPUTS])


@contextmanager
def nothing_written(folder: Path) -> Iterator[None]:
    """Assert that a folder holds afterwards what it held before."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    yield
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def refusal(result: Result) -> DataRefused:
    """Return what a command refused: exit code 3 and one line."""
    assert isinstance(result.exception, DataRefused), result.output
    code, line = explain(result.exception)
    assert (code, "\n" in line) == (3, False), line
    return result.exception

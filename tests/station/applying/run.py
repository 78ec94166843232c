"""`station apply` run in this process, and what it wrote read back."""

from pathlib import Path

import numpy as np
from typer.testing import CliRunner, Result

from station.cli import app
from station.exit_codes import explain

OUTPUTS = [f"{name}_{axis}_{unit}" for name, unit in (("f", "m_s2"), ("omega", "rad_s")) for axis in "xyz"]


def apply(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["apply", *map(str, arguments)])


def written(path: Path) -> np.ndarray:
    with np.load(path) as arrays:
        return np.column_stack([arrays[name] for name in OUTPUTS])


def refused(result: Result) -> str:
    code, line = explain(result.exception) if result.exception else (result.exit_code, result.output)
    assert code == 3, line
    assert "\n" not in line.strip()
    return line

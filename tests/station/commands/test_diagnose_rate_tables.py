"""What ``station diagnose`` says of a rate table: a wrong row by its line, a wrong unit, what --discover needs."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station import cli

NOISE = 2e-4  # deg/s
RATES = np.tile([0, 5, -5, 10, -10, 20, -20, 50, -50, 100, -100, 150, -150, 200, -200, 0.5, -0.5, 2.0, -2.0], 2)
WRONG = 20


def written(folder: Path, output: FloatArray) -> str:
    file = folder / "rates.csv"
    rows = [f"{u:.4f},{y:.8f}" for u, y in zip(RATES, output, strict=True)]
    file.write_text("\n".join(["rate_ref_deg_s,gz_deg_s", *rows]) + "\n")
    return str(file)


def seen(noise: float = NOISE) -> FloatArray:
    return 1.0003 * RATES + 0.002 + noise * np.random.default_rng(1).standard_normal(len(RATES))


def diagnosed(log: str, folder: Path, *options: str) -> dict[str, Any]:
    assert cli.run(["diagnose", log, "--json", str(folder / "found.json"), *options]) == 0
    found: dict[str, Any] = json.loads((folder / "found.json").read_text())
    return found


def messages_of(log: str, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    capsys.readouterr()
    assert cli.run(["diagnose", log, *options]) == 0
    return " ".join(capsys.readouterr().out.split())


def test_a_wrong_row_is_named_with_its_line_and_is_not_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = seen()
    output[WRONG] *= -1
    log = written(tmp_path, output)
    found = diagnosed(log, tmp_path)
    (finding,) = found["findings"]
    assert (finding["effect"], finding["where"]["line"]) == ("procedure.wrong_row", WRONG + 2)
    assert found["verdict"] == "established"
    scale = found["solution"]["rate_tables"]["gyroscope"]["scale_factor"]["z"]
    assert abs(scale["value"] - 1.0003) < 4 * scale["std"] < 1e-5
    assert f"line {WRONG + 2}" in messages_of(log, capsys)


def test_channels_that_the_table_does_not_turn_are_not_judged(tmp_path: Path) -> None:
    """Rounded, they do not follow the rate at all: nothing of them is an error in deg/s."""
    idle = np.round(0.002 * np.random.default_rng(2).standard_normal(len(RATES)), 2)
    idle[WRONG] = 1.0
    rows = [f"{u:.4f},{x:.2f},{y:.8f}" for u, x, y in zip(RATES, idle, seen(), strict=True)]
    (tmp_path / "rates.csv").write_text("\n".join(["rate_ref_deg_s,gx_deg_s,gz_deg_s", *rows]) + "\n")
    found = diagnosed(str(tmp_path / "rates.csv"), tmp_path, "--gyro", "gx_deg_s,-,gz_deg_s")
    assert found["findings"] == []


@pytest.mark.parametrize(("unit", "stated"), [(np.pi / 180, "rad/s"), (3600.0, "deg/h"), (1.0, ""), (1.1, "")])
def test_a_scale_factor_of_another_unit_is_reported(unit: float, stated: str, tmp_path: Path) -> None:
    warnings = " ".join(diagnosed(written(tmp_path, unit * seen()), tmp_path)["solution"]["warnings"])
    assert ("is probably wrong" in warnings, stated in warnings) == (bool(stated), True)


def test_a_search_is_not_offered_for_a_rate_table_and_says_what_it_needs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path, seen() + 0.01 * np.sin(RATES))
    assert diagnosed(log, tmp_path)["verdict"] in {"partly", "unexplained"}
    assert "--discover" not in messages_of(log, capsys)
    assert diagnosed(log, tmp_path, "--discover")["searched"]["terms"] == 0
    assert "it needs a campaign" in messages_of(log, capsys, "--discover")

"""imu_calib.yaml, read and applied as its node does: SM raw - bias."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from procedures.units import STANDARD_GRAVITY
from station import cli
from tests.station.calibrated.test_calibration_applied import D_A, E_A, K_A
from tests.station.exports.every_effect import every_effect


def document() -> dict[str, Any]:
    found = every_effect()
    found["accelerometer"]["scale_factor"]["unit"] = "count/(g s)"
    found["gyroscope"]["scale_factor"]["unit"] = "count/deg"
    return found


def test_the_node_gets_the_specific_force_back(tmp_path: Path) -> None:
    (tmp_path / "c.json").write_text(json.dumps(document()))
    out = tmp_path / "imu_calib.yaml"
    command = [
        "export",
        str(tmp_path / "c.json"),
        "--to",
        "imu_calib",
        "--nominal-accel",
        "1000",
        "--out",
        str(out),
    ]
    assert cli.run(command) == 0
    found = yaml.safe_load(out.read_text())
    assert set(found) == {"SM", "bias"}
    SM, bias = np.array(found["SM"], dtype=float), np.array(found["bias"], dtype=float)
    assert SM.shape == (9,)
    f = np.array([3.0, -7.0, 9.0])
    raw = K_A / 1000.0 * (E_A @ f + D_A * STANDARD_GRAVITY)
    assert SM.reshape(3, 3) @ raw - bias == pytest.approx(f, rel=1e-13)
    assert "NOT CARRIED: accelerometer.quadratic" in out.read_text()


def test_gyroscopes_alone_are_refused(tmp_path: Path) -> None:
    alone = document()
    del alone["accelerometer"]
    (tmp_path / "c.json").write_text(json.dumps(alone))
    assert cli.run(["export", str(tmp_path / "c.json"), "--to", "imu_calib", "--out", str(tmp_path / "out")]) == 3
    assert not (tmp_path / "out").exists()

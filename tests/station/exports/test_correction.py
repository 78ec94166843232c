"""A calibration as a flight stack applies it: numbers of one triad by hand, and the inverse of the model."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.errors import DataRefused
from station.exports.correction import read_correction
from tests.refusals import refused

E = [[1.0, 0.002, -0.003], [0.004, 0.999, 0.0], [0.0, 0.0, 1.001]]


def document() -> dict[str, Any]:
    def triad(k: list[float], D: list[float], unit: str) -> dict[str, Any]:
        return {
            "scale_factor": {"value": k, "unit": unit}, "misalignment": {"value": E}, "bias": {"value": D},
        }  # fmt: skip

    return {
        "format": "calibration/1", "model": "FOG", "serial": "7", "accepted_utc": "2026-01-02T12:00:00Z",
        "status": "accepted",
        "software": "station 1", "previous": "none", "effects": [],
        "accelerometer": triad([1000.0, 1002.0, 1010.0], [0.001, -0.002, 0.003], "count/(g s)"),
        "gyroscope": triad([-36000.0, -36010.0, -35990.0], [3.6, -7.2, 0.0], "count/deg"),
    }  # fmt: skip


def read(folder: Path, changed: dict[str, Any], **nominal: float) -> Any:
    (folder / "c.json").write_text(json.dumps(document() | changed))
    return read_correction(folder / "c.json", **nominal)


def test_a_reading_at_the_nominal_scale_is_corrected_by_offset_and_scale(tmp_path: Path) -> None:
    found = read(tmp_path, {}).accelerometer
    assert found.nominal.value == 1000.0  # the mean is 1004, to three digits
    np.testing.assert_allclose(found.gain, [1.0, 1.002, 1.01])
    np.testing.assert_allclose(found.D, np.multiply([0.001, -0.002, 0.003], 9.80665))
    np.testing.assert_allclose(found.offset, found.gain * found.D)
    np.testing.assert_allclose(found.matrix, np.diag(found.gain) @ E)
    np.testing.assert_allclose(found.scale, [1.0, 1 / (1.002 * 0.999), 1 / (1.01 * 1.001)])
    assert found.misalignment == pytest.approx(0.004)
    u = np.array([1.0, -2.0, 3.0])
    k = np.array([1000.0, 1002.0, 1010.0])
    raw = k / 1000.0 * (np.array(E) @ u + found.D)
    np.testing.assert_allclose((np.linalg.inv(found.matrix) @ (raw - found.offset)), u)


def test_gyros_are_in_rad_s_and_a_nominal_scale_may_be_given(tmp_path: Path) -> None:
    found = read(tmp_path, {}, gyro=-30000.0, accel=500.0)
    np.testing.assert_allclose(found.gyroscope.gain, [1.2, 36010 / 30000, 35990 / 30000])
    np.testing.assert_allclose(found.gyroscope.D, np.radians([0.001, -0.002, 0.0]))  # 3.6 deg/h
    assert found.accelerometer.nominal.value == 500.0


@pytest.mark.parametrize(
    "changed", [{"format": "solution/1"}, {"accelerometer": None, "gyroscope": None}, {"gyroscope": {}}]
)
def test_what_is_no_calibration_is_refused(changed: dict[str, Any], tmp_path: Path) -> None:
    with refused(DataRefused):
        read(tmp_path, changed)


def test_a_sensor_across_its_axis_is_refused(tmp_path: Path) -> None:
    across = document()["gyroscope"] | {"misalignment": {"value": [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0, 0, 1]]}}
    with refused(DataRefused):
        read(tmp_path, {"gyroscope": across})


def test_an_axis_that_counts_backwards_does_not_shrink_the_nominal_scale(tmp_path: Path) -> None:
    other = document()["gyroscope"]
    other["scale_factor"]["value"] = [36000.0, -36010.0, -35990.0]
    found = read(tmp_path, {"gyroscope": other}).gyroscope
    assert found.nominal.value == 36000.0
    np.testing.assert_allclose(found.gain, [1.0, -36010 / 36000, -35990 / 36000])

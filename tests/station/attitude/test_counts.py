"""What the calibration buys: counts of a tilted rest read to the horizon with it, and not without."""

from typing import Any

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.forward_right_down import inclination
from tests.station.attitude.counts import FORWARD_LEFT_UP, log_of_counts

K_A, K_G = np.array([1020e3, 1015e3, 1018e3]), np.array([36000.0, 35500.0, 36300.0])
E = np.array([[1.0, 1e-3, -2e-3], [5e-4, 1.0, 1e-3], [-1e-3, 2e-3, 1.0]])
D_A, D_G = np.array([3e-3, -2e-3, 3e-3]), np.array([50.0, -60.0, 40.0]) / 3600  # g, deg/s
QUADRATIC = 2e-3  # g/g2


def calibration(*effects: dict[str, Any], bias: bool = True) -> dict[str, Any]:
    def triad(k: np.ndarray, D: np.ndarray) -> dict[str, Any]:
        return {"scale_factor": {"value": k}, "misalignment": {"value": E}, "bias": {"value": D * bias}}

    return {"accelerometer": triad(K_A, D_A), "gyroscope": triad(K_G, 3600 * D_G), "effects": list(effects)}


def test_stored_calibration_and_its_effects_level_the_horizon() -> None:
    down = np.array([0.3, -0.2, np.sqrt(1 - 0.13)])
    f = -FORWARD_LEFT_UP.T @ down  # [g] in IMU axes
    t = np.delete(np.arange(1, 4001) * 0.02, slice(1500, 1600))  # a gap of 2 s
    accel = np.tile(K_A * (E @ f + D_A + QUADRATIC * f**2) * 0.02, (len(t), 1))
    gyro = np.tile(K_G * D_G * 0.02, (len(t), 1))
    effect = {
        "name": "accelerometer.quadratic", "unit": "g/g^2",
        "coefficients": {axis: {"value": QUADRATIC, "std": 0.0} for axis in "xyz"},
    }  # fmt: skip
    log, left = log_of_counts(calibration(effect), t, gyro, accel)
    assert left == ()
    assert log.omega_b == pytest.approx(0, abs=1e-9)
    assert np.degrees(inclination(estimate(log, "none").down[-1], down)) < 1e-3
    for poorer in (calibration(), calibration(effect, bias=False)):
        known, _ = log_of_counts(poorer, t, gyro, accel)
        assert np.degrees(inclination(estimate(known, "none").down[-1], down)) > 0.01


def test_an_effect_that_cannot_be_taken_off_is_said() -> None:
    effect = {
        "name": "gyroscope.bias_temperature",
        "unit": "deg/h/K",
        "coefficients": {"x": {"value": 1.0, "std": 0}},
    }
    t = np.arange(1, 101) * 0.02
    _, left = log_of_counts(calibration(effect), t, np.zeros((100, 3)), np.zeros((100, 3)))
    assert any("gyroscope.bias_temperature" in said for said in left)

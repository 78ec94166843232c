"""A calibration applied to rates gives back what the sensors went through, its effects taken off."""

from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station.calibrated.calibration_applied import Surroundings, calibrated_inputs

K_A, K_G = np.array([1010.0, 990.0, 1005.0]), np.array([36000.0, 35500.0, 36300.0])
E_A = np.array([[1.0, 1e-3, -2e-3], [5e-4, 1.0, 1e-3], [-1e-3, 2e-3, 1.0]])
E_G = np.array([[1.0, -7e-4, 2e-4], [1e-4, 1.0, 3e-4], [6e-4, -2e-4, 1.0]])
D_A, D_G = np.array([1e-3, -2e-3, 3e-3]), np.array([1.0, -2.0, 0.5])  # g, deg/h
DRAW = np.random.default_rng(5)
F, OMEGA = DRAW.uniform(-1, 1, (40, 3)), DRAW.uniform(-200, 200, (40, 3))
T = DRAW.uniform(5, 45, 40)


def calibration(*effects: dict[str, Any]) -> dict[str, Any]:
    def triad(k: FloatArray, E: FloatArray, D: FloatArray) -> dict[str, Any]:
        return {
            "scale_factor": {"value": k.tolist()}, "misalignment": {"value": E.tolist()},
            "bias": {"value": D.tolist()},
        }  # fmt: skip

    return {
        "format": "calibration/1", "accelerometer": triad(K_A, E_A, D_A), "gyroscope": triad(K_G, E_G, D_G),
        "effects": list(effects),
    }  # fmt: skip


def effect(name: str, shape: str = "", **coefficients: float) -> dict[str, Any]:
    found = {"name": name, "coefficients": {key: {"value": v, "std": 0.0} for key, v in coefficients.items()}}
    return {**found, "shape": shape} if shape else found


def put_out(accel: FloatArray | float = 0.0, gyro: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return the triads' rates with something added to E u + D [g], [deg/s]."""
    return K_A * (F @ E_A.T + D_A + accel), K_G * (OMEGA @ E_G.T + D_G / 3600 + gyro)


def test_without_effects_it_is_the_inverse_of_the_model() -> None:
    found = calibrated_inputs(calibration(), *put_out())
    assert found.f == pytest.approx(F, abs=1e-12)
    assert found.omega == pytest.approx(OMEGA, abs=1e-10)
    assert found.not_applied == ()


def test_effects_are_taken_off_to_the_last_digits() -> None:
    warm = T[:, None] - 25
    accel = 6e-5 * F**2 + warm * 1e-5 + 20e-6 * warm * (F @ E_A.T + D_A)
    gyro = np.zeros((40, 3))
    gyro[:, 0] = 0.7 / 3600 * F[:, 2]  # xz: sensor x, input z
    gyro += 1e-6 * 2.0 * OMEGA * abs(OMEGA)
    axes = ("x", "y", "z")
    known = calibration(
        effect("accelerometer.quadratic", **dict.fromkeys(axes, 6e-5)),
        effect("accelerometer.bias_temperature", **dict.fromkeys(axes, 1e-5)),
        effect("accelerometer.scale_temperature", **dict.fromkeys(axes, 20.0)),
        effect("gyroscope.g_sensitivity", xz=0.7),
        effect("gyroscope.scale_nonlinearity", "u |u|", **dict.fromkeys(axes, 2.0)),
    )
    rates = put_out(accel, gyro)
    found = calibrated_inputs(known, *rates, Surroundings(temperature=T))
    assert found.not_applied == ()
    assert found.f == pytest.approx(F, abs=1e-12)
    assert found.omega == pytest.approx(OMEGA, abs=1e-9)
    without = calibrated_inputs(calibration(), *rates)
    assert without.f is not None
    assert np.abs(without.f - F).max() > 1e-4  # else nothing was planted


def test_a_sine_is_undone_from_the_phase_that_is_written() -> None:
    s = np.array([2e-3, 3e-3, 4e-3])  # rad/(deg/s)
    rates = K_G * (np.sin(s * OMEGA) / s - OMEGA + OMEGA @ E_G.T + D_G / 3600)
    known = calibration(effect("gyroscope.sagnac_sine", x=2e-3, y=3e-3, z=4e-3))
    found = calibrated_inputs(known, None, rates)
    assert found.f is None
    assert found.omega == pytest.approx(OMEGA, abs=1e-6)


def test_what_cannot_be_taken_off_is_said_and_left_in() -> None:
    known = calibration(
        effect("accelerometer.bias_temperature", x=1e-5),
        effect("accelerometer.bias_drift", x=1e-5),
        effect("gyroscope.moonlight", x=1.0),
    )
    found = calibrated_inputs(known, *put_out())
    assert found.f == pytest.approx(F, abs=1e-12)
    assert len(found.not_applied) == 3
    assert found.not_applied[0].startswith("accelerometer.bias_temperature: what it depends on")

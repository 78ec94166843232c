"""A calibration applied to rates gives back what the sensors went through, its effects corrected."""

from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Backlash, Surroundings, TemperatureFollower

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


HOURS = np.linspace(0.0, 7200.0, 40)  # s


def followed(T: FloatArray, tau: float, t: FloatArray = HOURS) -> FloatArray:
    """What a sensor has come to, by Euler in steps of a tenth of a second."""
    fine = np.arange(t[0], t[-1] + 0.1, 0.1)
    outside, inside = np.interp(fine, t, T), np.empty(len(fine))
    inside[0] = outside[0]
    for i in range(1, len(fine)):
        inside[i] = inside[i - 1] + 0.1 / tau * ((outside[i] + outside[i - 1]) / 2 - inside[i - 1])
    return np.interp(t, fine, inside)


def test_a_polynomial_and_a_lag_of_temperature_are_taken_off() -> None:
    temperature = 30 + 20 * np.sin(HOURS / 1500)
    warm, sensor = temperature - 25, followed(temperature, 600.0) - 25
    accel, gyro = np.zeros((40, 3)), np.zeros((40, 3))
    accel[:, 0] = 1e-5 * warm - 3e-7 * warm**2 + 2e-8 * warm**3
    accel[:, 2] = -4e-5 * warm
    gyro[:, 1] = (0.3 * sensor - 0.01 * sensor**2) / 3600
    known = calibration(
        effect("accelerometer.bias_temperature", **{"x.1": 1e-5, "x.2": -3e-7, "x.3": 2e-8, "z.1": -4e-5}),
        effect("gyroscope.temperature_lag", **{"y.1": 0.3, "y.2": -0.01, "tau_s": 600.0}),
    )
    rates = put_out(accel, gyro)
    found = calibrated_inputs(known, *rates, Surroundings(temperature=temperature, t=HOURS))
    assert found.not_applied == ()
    assert found.f == pytest.approx(F, abs=1e-12)
    assert found.omega == pytest.approx(OMEGA, abs=4e-4 / 3600)  # Euler's own error
    timeless = calibrated_inputs(known, *rates, Surroundings(temperature=temperature))
    assert [each.partition(":")[0] for each in timeless.not_applied] == ["gyroscope.temperature_lag"]


def test_what_follows_vibration_and_backlash_of_no_width_are_not_corrected_and_reported() -> None:
    known = calibration(
        effect("accelerometer.temperature_hysteresis", "with a play", x=5e-5, play_k=0.0),
        effect("accelerometer.vibration_rectification", x=1e-3),
    )
    found = calibrated_inputs(known, *put_out(), Surroundings(temperature=T, t=HOURS))
    assert found.f == pytest.approx(F, abs=1e-12)
    assert [each.partition(":")[0] for each in found.not_applied] == [
        "accelerometer.temperature_hysteresis", "accelerometer.vibration_rectification",
    ]  # fmt: skip


def branch_of(T: FloatArray, width: float) -> FloatArray:
    """Where a hysteresis with a play is (n,): what is pushed along moves as temperature goes by small steps."""
    found = np.zeros(len(T))
    for i in range(1, len(T)):
        at = T[0]
        for j in range(i):  # from one temperature to the next, in a thousand steps
            for value in np.linspace(T[j], T[j + 1], 1001)[1:]:
                at += max(value - at - width, 0.0) - max(at - value - width, 0.0)
        found[i] = (T[i] - at) / width
    return found


def test_a_hysteresis_with_backlash_is_corrected_piece_by_piece() -> None:
    temperature = np.concatenate((np.linspace(20, 24, 8), np.linspace(23.5, 21, 6), np.linspace(21.4, 22.2, 4)))
    n, h = len(temperature), np.array([5e-5, -3e-5, 0.0])
    branch = branch_of(temperature, 1.2)
    assert branch.max() == pytest.approx(1.0)
    assert branch.min() < -0.5
    assert len(np.unique(np.round(branch, 6))) > 6  # between the branches, too
    rates = [part[:n] for part in put_out(np.resize(branch, 40)[:, None] * h, 0.0)]
    known = calibration(effect("accelerometer.temperature_hysteresis", "with a play", x=5e-5, y=-3e-5, play_k=1.2))
    whole = calibrated_inputs(known, *rates, Surroundings(temperature=temperature, t=HOURS[:n]))
    assert whole.not_applied == ()
    assert whole.f == pytest.approx(F[:n], abs=1e-12)
    follower, parts = TemperatureFollower((Backlash(1.2),)), []
    for i in range(0, n, 5):
        part = slice(i, min(i + 5, n))
        around = Surroundings(t=HOURS[part], signals=follower.take(HOURS[part], temperature[part]))
        parts.append(calibrated_inputs(known, rates[0][part], rates[1][part], around).f)
    assert np.array_equal(np.concatenate(parts), whole.f)


def test_what_cannot_be_corrected_is_reported() -> None:
    known = calibration(
        effect("accelerometer.bias_temperature", x=1e-5),
        effect("accelerometer.bias_drift", x=1e-5),
        effect("gyroscope.moonlight", x=1.0),
    )
    found = calibrated_inputs(known, *put_out())
    assert found.f == pytest.approx(F, abs=1e-12)
    assert len(found.not_applied) == 3

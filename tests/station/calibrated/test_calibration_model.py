"""A calibration as it is applied, on a few samples by hand: what is corrected, what is not, what is absent."""

from typing import Any

import numpy as np
import pytest

from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Surroundings


def triad(k: float, bias: tuple[float, float, float]) -> dict[str, Any]:
    return {
        "scale_factor": {"value": [k] * 3}, "misalignment": {"value": np.eye(3).tolist()},
        "bias": {"value": list(bias)},
    }  # fmt: skip


def effect(name: str, **coefficients: float) -> dict[str, Any]:
    return {"name": name, "coefficients": {key: {"value": v, "std": 0.0} for key, v in coefficients.items()}}


def calibration(*effects: dict[str, Any]) -> dict[str, Any]:
    """Return 1000 counts per g and second, a bias of 0.1 g in x; 10 counts per degree, 3600 deg/h in y."""
    return {
        "format": "calibration/1", "accelerometer": triad(1000.0, (0.1, 0.0, 0.0)),
        "gyroscope": triad(10.0, (0.0, 3600.0, 0.0)), "effects": list(effects),
    }  # fmt: skip


ACCEL = np.array([[1100.0, 0.0, -500.0], [100.0, 250.0, 0.0]])
GYRO = np.array([[50.0, 10.0, 0.0], [0.0, 30.0, -20.0]])
F, OMEGA = [[1.0, 0.0, -0.5], [0.0, 0.25, 0.0]], [[5.0, 0.0, 0.0], [0.0, 2.0, -2.0]]
LAG = effect("accelerometer.temperature_lag", x=1e-3, tau_s=600.0)
PLAY = {**effect("accelerometer.temperature_hysteresis", x=1e-3, play_k=1.5), "shape": "with a play"}
BIAS = effect("accelerometer.bias_temperature", x=1e-2, z=-2e-2)


def test_a_triad_that_is_not_given_or_not_calibrated_is_absent() -> None:
    found = calibrated_inputs(calibration(), ACCEL, None)
    assert found.f == pytest.approx(np.array(F), abs=1e-12)
    assert found.omega is None
    half = calibration()
    del half["accelerometer"]
    found = calibrated_inputs(half, ACCEL, GYRO)
    assert found.f is None
    assert found.omega == pytest.approx(np.array(OMEGA), abs=1e-12)
    found = calibrated_inputs(calibration(), None, None)
    assert (found.f, found.omega, found.unsettled.tolist()) == (None, None, [])


def test_a_gyro_needs_the_force_on_it_for_its_g_sensitivity() -> None:
    known = calibration(effect("gyroscope.g_sensitivity", xx=3600.0))
    both = calibrated_inputs(known, ACCEL, GYRO)
    assert both.not_applied == ()
    assert both.omega == pytest.approx(np.array([[4.0, 0.0, 0.0], [0.0, 2.0, -2.0]]), abs=1e-12)
    alone = calibrated_inputs(known, None, GYRO)
    assert [each.partition(":")[0] for each in alone.not_applied] == ["gyroscope.g_sensitivity"]
    assert alone.omega == pytest.approx(np.array(OMEGA), abs=1e-12)


def test_a_sample_that_is_none_is_none_and_not_unsettled() -> None:
    accel = ACCEL.copy()
    accel[0, 1] = np.nan
    found = calibrated_inputs(calibration(), accel, GYRO)
    assert found.f is not None
    assert np.isnan(found.f[0]).any()
    assert found.f[1] == pytest.approx(F[1], abs=1e-12)
    assert found.omega == pytest.approx(np.array(OMEGA), abs=1e-12)
    assert found.unsettled.tolist() == [False, False]


def test_a_temperature_rate_that_is_given_stands_before_the_one_found() -> None:
    """It is steady by its temperatures, and rises by half a kelvin a minute at first by what is given."""
    known = calibration(effect("accelerometer.temperature_rate", x=0.2))
    steady = {"temperature": np.full(2, 30.0), "t": np.array([0.0, 60.0])}
    plain = calibrated_inputs(known, ACCEL, None, Surroundings(**steady))
    assert plain.not_applied == ()
    assert plain.f == pytest.approx(np.array(F), abs=1e-12)
    given = Surroundings(**steady, temperature_rate=np.array([0.5, 0.0]))
    changed = calibrated_inputs(known, ACCEL, None, given)
    assert changed.f == pytest.approx(np.array([[0.9, 0.0, -0.5], [0.0, 0.25, 0.0]]), abs=1e-12)


def test_without_times_what_follows_them_is_left_in_and_what_does_not_is_taken_off() -> None:
    known = calibration(LAG, BIAS, effect("accelerometer.temperature_rate", x=0.2), PLAY)
    found = calibrated_inputs(known, ACCEL, None, Surroundings(temperature=np.array([35.0, 25.0])))
    left = {each.partition(":")[0] for each in found.not_applied}
    assert {LAG["name"], "accelerometer.temperature_rate", PLAY["name"]} == left
    assert found.f == pytest.approx(np.array([[0.9, 0.0, -0.3], [0.0, 0.25, 0.0]]), abs=1e-12)

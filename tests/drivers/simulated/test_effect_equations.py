"""What planted effects of a sensor add that no bench at rest shows (test_every_effect.py has the others)."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.effects import EFFECTS, Stimulus, TriadInput
from procedures.arrays import FloatArray

RAW = np.array([[0.5, -0.8, 1.2], [-1.1, 0.3, 0.7]])
BIAS = np.array([0.02, -0.03, 0.01])
SEEN = Stimulus(
    f=np.array([[0.1, -0.2, 0.9], [0.6, 0.7, -0.4]]), omega=np.zeros((2, 3)),
    magnetic=np.array([[20.0, -5.0, 43.0], [11.0, 30.0, -2.0]]), t=np.array([[500.0], [700.0]]),
    rest_s=np.array([[10.0], [45.0]]), temperature=np.array([[31.0], [22.0]]),
    temperature_rate=np.array([[0.4], [-1.5]]), position=3,
    temperature_at=lambda t: 20.0 + 0.02 * t,
)  # fmt: skip
TRIAD = TriadInput(RAW, BIAS)
C = np.array([2.0, -3.0, 5.0])
SIZES = {"x": 2.0, "y": -3.0, "z": 5.0}
T, RATE, TIME = SEEN.temperature, SEEN.temperature_rate, SEEN.t
M = np.array([[2.0, 0.5, 0.0], [0.0, -3.0, -0.25], [0.0, 0.0, 5.0]])  # sensor by input
LATER = np.array([[0.0], [1.0]])  # after 600 s
DPH = 1 / 3600

ADDED: dict[str, FloatArray] = {
    "accelerometer.temperature_rate": C * RATE,
    "accelerometer.temperature_hysteresis": C * np.sign(RATE),
    "gyroscope.temperature_hysteresis": C * np.sign(RATE) * DPH,
    "accelerometer.jump": C * LATER,
    "accelerometer.bias_settling": C * np.exp(-TIME / 300),
    "gyroscope.bias_settling": C * np.exp(-TIME / 300) * DPH,
    "accelerometer.scale_settling": 1e-6 * C * np.exp(-TIME / 300) * (RAW + BIAS),
    "gyroscope.jump": C * LATER * DPH,
    "gyroscope.scale_settling": 1e-6 * C * np.exp(-TIME / 300) * (RAW + BIAS),
}


def added(name: str, sizes: dict[str, float]) -> FloatArray:
    effect = EFFECTS[name]
    act = effect.accel if name.startswith("accelerometer") else effect.gyro
    assert act is not None
    assert (effect.accel is None) == name.startswith("gyroscope")
    return np.asarray(act(SEEN, TRIAD, {**effect.options, **sizes}))


@pytest.mark.parametrize("name", ADDED)
def test_an_effect_adds_what_its_equation_says(name: str) -> None:
    np.testing.assert_allclose(added(name, SIZES), ADDED[name], rtol=1e-12)
    assert EFFECTS[name].keys[:3] == ("x", "y", "z")


@pytest.mark.parametrize(("name", "per"), [("accelerometer.bias_cycle", 1.0), ("gyroscope.bias_cycle", DPH)])
def test_a_cycle_is_a_sine_and_a_cosine_of_one_period(name: str, per: float) -> None:
    found = added(name, {"x.sin": 2.0, "x.cos": 1.0, "z.cos": 5.0, "period_s": 2400.0})  # t: 75 and 105 deg
    np.testing.assert_allclose(found[0] / per, [2 * 0.9659258 + 0.2588190, 0.0, 5 * 0.2588190], atol=1e-6)
    np.testing.assert_allclose(found[1] / per, [2 * 0.9659258 - 0.2588190, 0.0, -5 * 0.2588190], atol=1e-6)


@pytest.mark.parametrize(
    ("name", "acts"), [("gyroscope.g_sensitivity", SEEN.f), ("gyroscope.magnetic", SEEN.magnetic)]
)
def test_a_matrix_is_of_sensor_by_input_and_one_letter_is_its_diagonal(name: str, acts: FloatArray) -> None:
    sizes = {**SIZES, "xy": 0.5, "yz": -0.25}
    np.testing.assert_allclose(added(name, sizes), acts @ M.T * DPH, rtol=1e-12)
    np.testing.assert_allclose(added(name, {"xx": 1.5, "x": 0.5})[:, 0], 2.0 * acts[:, 0] * DPH, rtol=1e-12)


def test_products_are_of_a_sensors_own_and_another_input_or_of_any_two() -> None:
    found = added("accelerometer.cross_product", {"xy": 2.0, "zx": 3.0, "yxz": 5.0, "xxy": 7.0})
    x, y, z = RAW.T
    np.testing.assert_allclose(found, np.stack((9.0 * x * y, 5.0 * x * z, 3.0 * z * x), axis=1), rtol=1e-12)


def test_counts_are_lost_above_the_knee_alone() -> None:
    found = added("gyroscope.counts_lost", {**SIZES, "knee_deg_s": 0.6})
    out = RAW + BIAS
    np.testing.assert_allclose(found, -1e-6 * C * (out - np.clip(out, -0.6, 0.6)), rtol=1e-12)


def test_an_output_stays_at_the_ends_of_its_range() -> None:
    out = RAW + BIAS + added("gyroscope.saturation", {"x+": 0.5, "x-": -1.0, "z+": 0.9})
    np.testing.assert_allclose(out, [[0.5, -0.83, 0.9], [-1.0, 0.27, 0.71]], rtol=1e-12)


@pytest.mark.parametrize("name", ["accelerometer.jump", "gyroscope.jump"])
def test_a_jump_may_be_of_scale_and_at_another_time(name: str) -> None:
    found = added(name, {**SIZES, "scale": 1.0})
    np.testing.assert_allclose(found, 1e-6 * C * (RAW + BIAS) * LATER, rtol=1e-12)
    assert (added(name, {**SIZES, "after_s": 499.0}) != 0.0).all()
    assert not added(name, {**SIZES, "after_s": 700.0}).any()


@pytest.mark.parametrize(
    ("name", "unit"), [("accelerometer.temperature_lag", 1.0), ("gyroscope.temperature_lag", DPH)]
)
def test_a_sensor_lags_behind_a_ramp_by_what_its_equation_says(name: str, unit: float) -> None:
    sensor = 20.0 + 0.02 * TIME - 0.02 * 300 * -np.expm1(-TIME / 300)
    np.testing.assert_allclose(added(name, SIZES), C * (sensor - 25) * unit, rtol=1e-3)
    found = added(name, {"y.2": 4.0, "y.1": 3.0})[:, 1:2]
    np.testing.assert_allclose(found, (3.0 * (sensor - 25) + 4.0 * (sensor - 25) ** 2) * unit, rtol=1e-3)


def test_a_bench_shakes_in_odd_positions_and_what_it_adds_follows_the_square() -> None:
    wave = np.sqrt(2) * 0.02 * np.sin(2 * np.pi * 2.3 * TIME)  # along every axis; a gyroscope feels all three
    of_accel, of_gyro = (EFFECTS[f"{triad}.vibration_rectification"] for triad in ("accelerometer", "gyroscope"))
    sizes = {**of_gyro.options, **SIZES}
    for act, expected in (
        (of_accel.accel, wave + C * wave**2),
        (of_gyro.accel, wave + np.zeros(3)),
        (of_gyro.gyro, 3 * C * DPH * wave**2),
    ):
        assert act is not None
        np.testing.assert_allclose(act(SEEN, TRIAD, sizes), expected, rtol=1e-12)
        assert not np.any(act(replace(SEEN, position=4), TRIAD, sizes))
    assert of_accel.gyro is None

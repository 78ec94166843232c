"""Runs in an oven at one attitude: what was planted is named, and nothing of it is ambiguous."""

from collections.abc import Callable

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from procedures.effects.temperature_history import lagged

KNOTS_S, KNOTS_C = np.array([0, 20, 70, 90, 150]) * 60.0, np.array([20.0, 20.0, 55.0, 55.0, 20.0])
T = np.arange(0, 9000.0, 1.0)
UP = np.array([0.012, -0.02, 0.9997])


def oven(seed: int, accel: FloatArray | float, gyro: FloatArray | float) -> Diagnosis:
    """Diagnose 2.5 h with ``accel`` [g] and ``gyro`` [deg/s] (n, 3) beside noise of a cheap unit's 1 s means."""
    rng = np.random.default_rng(seed)
    n, temperature = len(T), np.interp(T, KNOTS_S, KNOTS_C)
    f = UP + accel + 1e-4 * rng.standard_normal((n, 3))
    w = gyro + 1.3e-3 * rng.standard_normal((n, 3)) + np.array([0.11, -0.07, 0.02])
    series = RateSeries(T + 1.0, w, f, temperature + 0.02 * rng.standard_normal(n), 1.0)
    soaks = (SoakRecord("oven", 0, None, series),)
    told = {"accelerometer": 1.0, "gyroscope": 1.0}
    return diagnose([Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=soaks, nominal_scale=told)])


def on(axis: int, values: FloatArray) -> FloatArray:
    return np.outer(values, np.eye(3)[axis])


@pytest.mark.parametrize("seed", [1])
def test_a_lag_and_lines_in_the_temperature_are_named_and_none_is_ambiguous(seed: int) -> None:
    temperature = np.interp(T, KNOTS_S, KNOTS_C) - 25
    follows = lagged(T, np.interp(T, KNOTS_S, KNOTS_C), 540.0) - 25
    found = oven(seed, on(2, 85e-6 * follows) + on(0, -30e-6 * temperature), on(1, 4.2 / 3600 * temperature))
    by_name = {each.effect: each for each in found.findings}
    assert set(by_name) == {
        "gyroscope.bias_temperature", "accelerometer.temperature_lag", "accelerometer.bias_temperature",
    }  # fmt: skip
    assert {each.confidence for each in found.findings} <= {"established", "likely"}
    assert found.verdict in {"established", "likely"}
    lag = dict(zip(by_name["accelerometer.temperature_lag"].coefficients,
                   by_name["accelerometer.temperature_lag"].value, strict=True))  # fmt: skip
    assert lag["z"] == pytest.approx(85e-6, rel=0.1)
    assert lag["tau_s"] == pytest.approx(540, rel=0.15)
    assert by_name["accelerometer.temperature_lag"].same_here == ("accelerometer.scale_temperature_lag",)
    assert by_name["accelerometer.bias_temperature"].same_here == ("accelerometer.scale_temperature",)
    assert by_name["gyroscope.bias_temperature"].same_here == ()


@pytest.mark.parametrize(
    "shape",
    [
        lambda t: np.sin(2 * np.pi * t / 1300.0),
        lambda t: np.where((t > 2000) & (t < 3100), 1.0, 0.0) * np.sin(2 * np.pi * t / 500.0),
    ],
)
def test_what_no_effect_does_is_not_explained_beside_one_that_is(
    shape: Callable[[FloatArray], FloatArray],
) -> None:
    temperature = np.interp(T, KNOTS_S, KNOTS_C) - 25
    found = oven(3, on(2, 3e-4 * shape(T)), on(1, 4.2 / 3600 * temperature))
    assert found.verdict in {"partly", "unexplained"}
    assert found.reasons
    gyro = next(each for each in found.findings if each.effect == "gyroscope.bias_temperature")
    assert gyro.confidence != "ambiguous"  # what the accelerometers do says nothing of it

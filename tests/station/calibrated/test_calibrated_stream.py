"""A calibration applied part by part: the same numbers as at once, and what is said of what it could not do."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.calibrated_stream import BLOCK, CalibrationStream
from station.errors import DataRefused
from tests.refusals import refused
from tests.station.calibrated.test_calibration_applied import OMEGA, F, calibration, effect, put_out

G = 9.80665
PERIOD = 0.01
C = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
N = len(F)
T = (100.0 + PERIOD * np.arange(N)).astype(np.float64)
ACCEL, GYRO = put_out()
RATES = np.hstack((GYRO, ACCEL))


def stream_of(document: dict[str, Any], period: float | None = None) -> CalibrationStream:
    return CalibrationStream(CalibrationModel.of(document), document, C, period)


@dataclass
class Parts:
    """What a stream gave of parts, end to end, and what it said at last."""

    stream: CalibrationStream
    f: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    omega: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    reported: tuple[str, ...] = ()

    def take(
        self, rows: slice = slice(None), rates: FloatArray = RATES, t: FloatArray = T, temperature: Any = None,
        auxiliary: Any = None, magnetic: Any = None, *, is_last: bool = False,
    ) -> "Parts":  # fmt: skip
        part = [None if each is None else each[rows] for each in (temperature, magnetic)]
        inputs = {name: value[rows] for name, value in auxiliary.items()} if auxiliary else auxiliary
        found = self.stream.apply(rates[rows], t[rows], part[0], inputs, magnetic=part[1], last=is_last)
        self.f = np.vstack((self.f, found.specific_force))
        self.omega = np.vstack((self.omega, found.angular_rate))
        self.reported = found.warnings
        return self


def taken(document: dict[str, Any], *, step: int = N, period: float | None = None, **given: Any) -> Parts:
    """Return what a stream gives of all samples, ``step`` at a time."""
    parts, n = Parts(stream_of(document, period)), len(given.get("t", T))
    for begin in range(0, n, step):
        parts.take(slice(begin, begin + step), **given, is_last=begin + step >= n)
    return parts


def test_rates_and_counts_give_what_was_felt_in_the_axes_asked_for() -> None:
    felt = F @ C.T * G, np.radians(OMEGA) @ C.T
    of_rates = taken(calibration())
    assert of_rates.f == pytest.approx(felt[0], abs=1e-9)
    assert of_rates.omega == pytest.approx(felt[1], abs=1e-9)
    of_counts = taken(calibration(), rates=RATES * PERIOD, period=PERIOD)
    assert of_counts.f == pytest.approx(felt[0], abs=1e-9)
    assert of_counts.omega == pytest.approx(felt[1], abs=1e-9)
    assert of_counts.reported == ()


def test_more_samples_than_a_block_are_applied_as_in_parts() -> None:
    n = BLOCK + 37
    rates, t = np.resize(RATES, (n, 6)), PERIOD * np.arange(n)
    temperature = 25 + 5 * np.sin(t / 20)
    known = calibration(effect("accelerometer.temperature_lag", x=1e-3, y=-2e-3, z=3e-3, tau_s=30.0))
    whole = taken(known, step=n, rates=rates, t=t, temperature=temperature)
    parts = taken(known, step=5001, rates=rates, t=t, temperature=temperature)
    assert np.isfinite(whole.f).all()
    assert np.array_equal(whole.f, parts.f)
    assert np.array_equal(whole.omega, parts.omega)


MAGNETIC = effect("gyroscope.magnetic", xx=30.0, yy=-20.0, zy=10.0)


@pytest.mark.parametrize("step", [N, 7, 1])
def test_a_field_that_is_not_given_is_that_of_the_sample_before(step: int) -> None:
    whole = np.random.default_rng(3).normal(0, 40, (N, 3))
    gaps, filled = whole.copy(), whole.copy()
    for row in (5, 6, 13, 14, 20):
        gaps[row, row % 3] = np.nan
    for row in (5, 6, 13, 14, 20):
        filled[row] = filled[row - 1]
    found = taken(calibration(MAGNETIC), step=step, magnetic=gaps)
    assert np.array_equal(found.omega, taken(calibration(MAGNETIC), magnetic=filled).omega)
    assert not np.array_equal(found.omega, taken(calibration(), magnetic=whole).omega)


def test_what_a_field_adds_is_taken_off() -> None:
    field = np.random.default_rng(4).normal(0, 40, (N, 3))
    added = field[:, [0, 1, 1]] * np.array([30.0, -20.0, 10.0]) / 3600
    rates = np.hstack((put_out(gyro=added)[1], ACCEL))
    found = taken(calibration(MAGNETIC), step=9, rates=rates, magnetic=field)
    assert found.omega == pytest.approx(np.radians(OMEGA) @ C.T, abs=1e-9)


def test_an_effect_whose_cause_is_not_recorded_is_left_in_and_counted() -> None:
    parts = Parts(stream_of(calibration(MAGNETIC)))
    field = np.full((N, 3), 10.0)
    assert not parts.take(slice(0, 25), magnetic=field).reported
    (reported,) = parts.take(slice(25, 40)).reported
    assert all(value in reported for value in ("gyroscope.magnetic", "15 of 40 samples", "1500 deg/h"))
    (always,) = taken(calibration(MAGNETIC), step=8).reported
    assert "gyroscope.magnetic" in always


def test_an_effect_of_a_triad_that_is_not_there_is_not_left_in() -> None:
    without = np.hstack((np.full((N, 3), np.nan), ACCEL))
    found = taken(calibration(MAGNETIC), rates=without)
    assert found.reported == ()
    assert np.isnan(found.omega).all()
    assert found.f == pytest.approx(F @ C.T * G, abs=1e-9)


def test_an_output_beyond_all_bounds_is_none_and_the_rest_goes_on() -> None:
    rates = RATES.copy()
    rates[3, 4], rates[5, 0] = -1e30, np.inf
    found = taken(calibration(), rates=rates)
    assert np.flatnonzero(np.isnan(found.f).any(axis=1)).tolist() == [3]
    assert np.flatnonzero(np.isnan(found.omega).any(axis=1)).tolist() == [5]
    assert found.reported == ()


@pytest.mark.parametrize(
    ("low", "high", "is_reported"),
    [(9.55, 40.45, False), (9.45, 30.0, True), (20.0, 40.55, True), (15.0, 35.0, False)],
)
def test_temperatures_are_outside_beyond_half_a_kelvin(low: float, high: float, *, is_reported: bool) -> None:
    document = {**calibration(), "temperature_range_c": [10.0, 40.0]}
    temperature = np.full(N, 25.0)
    temperature[10], temperature[30] = low, high
    reported = taken(document, step=15, temperature=temperature).reported
    assert len(reported) == is_reported
    assert all(f"{low:.1f} to {high:.1f} degC" in each and "1 of 40 samples" in each for each in reported)
    assert taken(calibration(), temperature=temperature).reported == ()


@pytest.mark.parametrize(
    ("second", "found"),
    [([2.0, 3.0], "sample 2"), ([1.5, 3.0], "sample 2"), ([3.0, 3.0], "sample 3"), ([3.0, np.nan], "sample 3")],
)
def test_times_rise_from_sample_to_sample_and_from_part_to_part(second: list[float], found: str) -> None:
    parts = Parts(stream_of(calibration()))
    parts.take(rates=RATES[:2], t=np.array([1.0, 2.0]))
    with refused(DataRefused, None, found):
        parts.take(rates=RATES[2:4], t=np.array(second))
    parts.take(rates=RATES[2:4], t=np.array([2.5, 2.6]))  # what was refused changed nothing


@pytest.mark.parametrize(
    ("given", "reported"),
    [
        ({"rates": RATES[:, :5]}, "(40, 5)"),
        ({"t": T[:, None]}, "(40, 1)"),
        ({"temperature": np.zeros((40, 1))}, "(40, 1)"),
        ({"magnetic": np.zeros((40, 2))}, "(40, 2)"),
        ({"auxiliary": {"aux_p": np.zeros(40)[:-1]}}, "(39,)"),
    ],
)
def test_arrays_that_do_not_go_together_are_refused(given: dict[str, Any], reported: str) -> None:
    with refused(DataRefused, None, reported):
        Parts(stream_of(calibration())).take(**given)

"""A calibration applied part by part: the same numbers as at once, and what is said of what it could not do."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station.calibrated.calibrated_stream import BLOCK, CalibratedStream
from station.calibrated.calibration_applied import CalibrationModel
from station.errors import DataRefused
from tests.station.calibrated.test_calibration_applied import OMEGA, F, calibration, effect, put_out

G = 9.80665
PERIOD = 0.01
C = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
N = len(F)
T = (100.0 + PERIOD * np.arange(N)).astype(np.float64)
ACCEL, GYRO = put_out()
RATES = np.hstack((GYRO, ACCEL))


def stream_of(document: dict[str, Any], period: float | None = None) -> CalibratedStream:
    return CalibratedStream(CalibrationModel.of(document), document, C, period)


@dataclass
class Parts:
    """What a stream gave of parts, end to end, and what it said at last."""

    stream: CalibratedStream
    f: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    omega: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    said: tuple[str, ...] = ()

    def take(
        self, rows: slice = slice(None), rates: FloatArray = RATES, t: FloatArray = T, temperature: Any = None,
        auxiliary: Any = None, magnetic: Any = None, *, is_last: bool = False,
    ) -> "Parts":  # fmt: skip
        part = [None if each is None else each[rows] for each in (temperature, magnetic)]
        beside = {name: value[rows] for name, value in auxiliary.items()} if auxiliary else auxiliary
        f, omega, _, self.said = self.stream.take(rates[rows], t[rows], part[0], beside, part[1], is_last=is_last)
        self.f, self.omega = np.vstack((self.f, f)), np.vstack((self.omega, omega))
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
    assert of_counts.said == ()


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
def test_a_field_that_is_not_told_is_that_of_the_sample_before(step: int) -> None:
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
    assert not parts.take(slice(0, 25), magnetic=field).said
    (said,) = parts.take(slice(25, 40)).said
    assert said.startswith(
        "gyroscope.magnetic is left in, in 15 of 40 samples, what it depends on was not recorded"
    )
    assert said.endswith("(up to 1500 deg/h)")
    (always,) = taken(calibration(MAGNETIC), step=8).said
    assert always.startswith("gyroscope.magnetic is left in, what it depends on was not recorded (up to")


def test_an_effect_of_a_triad_that_is_not_there_is_not_left_in() -> None:
    without = np.hstack((np.full((N, 3), np.nan), ACCEL))
    found = taken(calibration(MAGNETIC), rates=without)
    assert found.said == ()
    assert np.isnan(found.omega).all()
    assert found.f == pytest.approx(F @ C.T * G, abs=1e-9)


def test_an_output_beyond_all_bounds_is_none_and_the_rest_goes_on() -> None:
    rates = RATES.copy()
    rates[3, 4], rates[5, 0] = -1e30, np.inf
    found = taken(calibration(), rates=rates)
    assert np.flatnonzero(np.isnan(found.f).any(axis=1)).tolist() == [3]
    assert np.flatnonzero(np.isnan(found.omega).any(axis=1)).tolist() == [5]
    assert found.said == ()


@pytest.mark.parametrize(
    ("low", "high", "is_said"),
    [(9.55, 40.45, False), (9.45, 30.0, True), (20.0, 40.55, True), (15.0, 35.0, False)],
)
def test_temperatures_are_outside_beyond_half_a_kelvin(low: float, high: float, *, is_said: bool) -> None:
    document = {**calibration(), "temperature_range_c": [10.0, 40.0]}
    temperature = np.full(N, 25.0)
    temperature[10], temperature[30] = low, high
    said = taken(document, step=15, temperature=temperature).said
    expected = (
        f"temperature was {low:.1f} to {high:.1f} degC, the calibration's 10.0 to 40.0 degC, in 1 of 40 samples: "
        "outside it nothing is known"
    )
    assert said == ((expected,) if is_said else ())
    assert taken(calibration(), temperature=temperature).said == ()


def test_samples_are_counted_as_outside_beyond_the_same_half_kelvin() -> None:
    document = {**calibration(), "temperature_range_c": [10.0, 40.0]}
    temperature = np.full(N, 25.0)
    temperature[[3, 5, 7, 9, 11, 13]] = 9.0, 9.6, 10.4, 39.6, 40.4, 41.0
    (said,) = taken(document, temperature=temperature).said
    assert "temperature was 9.0 to 41.0 degC" in said
    assert "in 2 of 40 samples" in said


def test_samples_that_are_all_outside_are_said_without_their_number() -> None:
    document = {**calibration(), "temperature_range_c": [10.0, 40.0]}
    (said,) = taken(document, step=9, temperature=np.full(N, 50.0)).said
    assert said == (
        "temperature was 50.0 to 50.0 degC, the calibration's 10.0 to 40.0 degC: outside it nothing is known"
    )
    cold = np.where(np.arange(N) < 13, 5.0, 50.0)
    (said,) = taken(document, step=9, temperature=cold).said
    assert said.startswith("temperature was 5.0 to 50.0 degC, the calibration's 10.0 to 40.0 degC: outside")


def test_samples_before_the_first_temperature_are_counted() -> None:
    temperature = np.full(N, 25.0)
    temperature[:12], temperature[20:25] = np.nan, np.nan  # a gap later on is bridged
    assert taken(calibration(), step=5, temperature=temperature).said == (
        "the first 12 samples have no temperature: its effects are left in",
    )
    assert taken(calibration(), step=5).said == ()  # none at all is told by the effects


SINE = effect("gyroscope.sagnac_sine", z=1e-2)  # puts out 100 deg/s at the most


def of_rate(z: FloatArray) -> FloatArray:
    """Return outputs (n, 6) of gyroscopes that put out ``z`` (n,) [deg/s] about z."""
    rates = np.zeros((len(z), 6))
    rates[:, 2] = 36300.0 * z
    return rates


def test_samples_that_do_not_settle_are_said_with_the_first_and_refused_at_the_end_if_they_are_many() -> None:
    n, known = 2500, calibration(SINE)
    t = (PERIOD * np.arange(n)).astype(np.float64)
    z = np.zeros(n)
    z[[700, 1900]] = 500.0  # two of 2500 are few
    few = taken(known, step=1000, rates=of_rate(z), t=t)
    assert few.said == (
        "found gyroscope.sagnac_sine not to settle in 2 of 2500 samples, the first at 7 s: nan there",
    )
    assert np.flatnonzero(np.isnan(few.omega).any(axis=1)).tolist() == [700, 1900]
    assert np.isfinite(few.f).all()
    z[2000] = 500.0
    parts = Parts(stream_of(known))
    for begin in (0, 1000):
        parts.take(slice(begin, begin + 1000), rates=of_rate(z), t=t)
    with pytest.raises(DataRefused) as refused:
        parts.take(slice(2000, n), rates=of_rate(z), t=t, is_last=True)
    assert "gyroscope.sagnac_sine not to settle in 3 of 2500 samples, the first at 7 s" in str(refused.value)
    assert "expected at most 1 in 1000, as effects are small against the input" in str(refused.value)


@pytest.mark.parametrize(("wild", "is_refused"), [(1, False), (2, True)])
def test_one_sample_that_does_not_settle_is_never_too_many(wild: int, *, is_refused: bool) -> None:
    z = np.zeros(N)
    z[10 : 10 + wild] = 500.0
    parts = Parts(stream_of(calibration(SINE)))
    assert "not to settle" in parts.take(rates=of_rate(z)).said[0]  # more may come
    parts = Parts(stream_of(calibration(SINE)))
    if is_refused:
        with pytest.raises(DataRefused, match=r"in 2 of 40 samples, the first at 100\.1 s"):
            parts.take(rates=of_rate(z), is_last=True)
    else:
        assert "in 1 of 40 samples" in parts.take(rates=of_rate(z), is_last=True).said[0]


def test_only_effects_of_the_triad_that_does_not_settle_are_named() -> None:
    z = np.zeros(N)
    z[3] = 500.0
    known = calibration(effect("accelerometer.quadratic", x=6e-5), SINE)
    (said,) = taken(known, rates=of_rate(z)).said
    assert said.startswith("found gyroscope.sagnac_sine not to settle")


def test_a_calibration_that_is_measured_alone_is_said() -> None:
    measured = {**calibration(), "status": "measured", "status_reason": "no turn was made"}
    assert taken(measured).said == ("the calibration is measured, not calibrated: no turn was made",)
    assert taken({**calibration(), "status": "calibrated"}).said == ()


@pytest.mark.parametrize(
    ("second", "found"),
    [
        ([2.0, 3.0], "found t 2 after 2 in sample 2"), ([1.5, 3.0], "found t 1.5 after 2 in sample 2"),
        ([3.0, 3.0], "found t 3 after 3 in sample 3"), ([3.0, np.nan], "found t nan after 3 in sample 3"),
        ([np.inf, 4.0], "found t 4 after inf in sample 3"),
    ],
)  # fmt: skip
def test_times_rise_from_sample_to_sample_and_from_part_to_part(second: list[float], found: str) -> None:
    parts = Parts(stream_of(calibration()))
    parts.take(rates=RATES[:2], t=np.array([1.0, 2.0]))
    with pytest.raises(DataRefused) as refused:
        parts.take(rates=RATES[2:4], t=np.array(second))
    assert found in str(refused.value)
    parts.take(rates=RATES[2:4], t=np.array([2.5, 2.6]))  # what was refused changed nothing


def test_a_first_time_that_is_none_is_refused_and_a_part_of_nothing_is_not() -> None:
    with pytest.raises(DataRefused, match="found t nan after nan in sample 0"):
        taken(calibration(), rates=RATES[:2], t=np.array([np.nan, 1.0]))
    parts = Parts(stream_of(calibration())).take(slice(0, 3)).take(slice(3, 3)).take(slice(3, 6), is_last=True)
    assert len(parts.f) == 6


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"rates": RATES[:, :5]}, "counts of shape (40, 5) and t of (40,), expected (n, 6) and (n,)"),
        ({"rates": RATES[:39]}, "counts of shape (39, 6) and t of (40,)"),
        ({"t": T[:, None]}, "counts of shape (40, 6) and t of (40, 1)"),
        ({"temperature": np.zeros((40, 1))}, "temperature: found shape (40, 1), expected (40,)"),
        ({"magnetic": np.zeros((40, 2))}, "magnetic: found shape (40, 2), expected (40, 3)"),
        ({"auxiliary": {"aux_p": np.zeros(40)[:-1]}}, "auxiliary aux_p: found shape (39,), expected (40,)"),
    ],
)
def test_arrays_that_do_not_go_together_are_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(DataRefused) as refused:
        Parts(stream_of(calibration())).take(**given)
    assert said in str(refused.value)


def test_channels_are_given_by_name() -> None:
    with pytest.raises(DataRefused, match="auxiliary: found list, expected channels by name; give a dict"):
        stream_of(calibration()).take(RATES, T, None, [1.0], None, is_last=True)


def test_a_channel_on_which_nothing_depends_changes_nothing() -> None:
    beside = np.where(np.arange(N) % 3, 1.0, np.nan)
    found = taken(calibration(), step=7, auxiliary={"aux_pressure": beside, "humidity": beside})
    assert np.array_equal(found.omega, taken(calibration()).omega)
    assert found.said == ()

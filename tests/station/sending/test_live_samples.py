"""Calibrated samples of a simulated unit: values by an evaluation of its own, flags, moments and UTC."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drivers.simulated.faults import Fault
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock
from station.calibration import calibration_of as library_of
from station.sending.live_samples import SampleTimes
from station.sending.outputs import CalibratedSamples, Quality, names
from tests.station.monitor.unit import G, calibration_of
from tests.station.sending.effects import EFFECTS
from tests.station.sending.rig import UNIT, LiveRig

FREE = Quality.GAP_BEFORE | Quality.BEGUN_ANEW  # what a single sample has, not a run


def marked(samples: CalibratedSamples, flag: Quality) -> list[int]:
    return np.flatnonzero(samples.flags & np.uint32(flag)).tolist()


def evaluated(document: dict[str, Any], triad: str, counts: FloatArray, period: float) -> FloatArray:
    """Return u of N = k (E u + D) sample by sample; D of gyroscopes is in deg/h."""
    k, E, D = (np.array(document[triad][part]["value"]) for part in ("scale_factor", "misalignment", "bias"))
    D = D / 3600 if triad == "gyroscope" else D
    return np.array([np.linalg.solve(E, row / period / k - D) for row in counts])


def test_values_are_those_of_the_calibration_to_1e_12() -> None:
    rig = LiveRig()
    found, sent, document = rig.run(5.0), rig.sent(), calibration_of(UNIT)
    assert isinstance(sent, CountBlock)
    rows = np.searchsorted(sent.device_time, found.t)
    assert len(found) > 450
    assert found.t == pytest.approx(sent.device_time[rows], rel=0, abs=0)
    f = evaluated(document, "accelerometer", sent.accel[rows], UNIT.sample_period_s) * G
    omega = np.radians(evaluated(document, "gyroscope", sent.gyro[rows], UNIT.sample_period_s))
    assert np.abs(found.f - f).max() < 1e-12 * np.abs(f).max()
    assert np.abs(found.omega - omega).max() < 1e-12 * np.abs(omega).max()
    assert found.temperature == pytest.approx(sent.temperature[rows])


def test_values_are_the_librarys_with_effects_too() -> None:
    document = calibration_of(UNIT) | {"effects": EFFECTS}
    rig = LiveRig(calibration=document)
    found, sent = rig.run(5.0), rig.sent()
    rows = np.searchsorted(sent.device_time, found.t)
    counts = np.hstack((sent.gyro, sent.accel))[rows]
    library = library_of(document)
    assert set(library.effects) == {entry["name"] for entry in EFFECTS}
    received = library.apply(counts, found.t, sent.temperature[rows], period=UNIT.sample_period_s)
    assert np.abs(found.f - received.specific_force).max() <= 1e-12 * np.abs(found.f).max()
    assert np.abs(found.omega - received.angular_rate).max() <= 1e-12 * np.abs(found.omega).max()
    assert not found.flags[1:].any()


def test_sequence_rises_by_one_and_an_untroubled_run_has_no_flag_but_at_its_beginning() -> None:
    found = LiveRig().run(3.0)
    assert found.sequence.tolist() == list(range(len(found)))
    assert names(int(found.flags[0])) == ["begun_anew"]
    assert not found.flags[1:].any()
    assert np.isnan(found.utc).all()


def test_lost_frames_are_a_gap_with_their_number() -> None:
    rig = LiveRig([Fault("lost", at_s=2.0, count=7)])
    found = rig.run(4.0)
    (row,) = marked(found, Quality.GAP_BEFORE)
    assert found.lost.sum() == found.lost[row] == 7
    assert found.t[row] - found.t[row - 1] == pytest.approx(8 * UNIT.sample_period_s)
    assert (rig.samples.lost, rig.samples.gaps) == (7, 1)
    assert found.sequence.tolist() == list(range(len(found)))


@pytest.mark.parametrize("kind", ["unplug", "counter_restart", "restart"])
def test_a_new_beginning_is_reported(kind: str) -> None:
    found = LiveRig([Fault(kind, at_s=2.0, seconds=0.5)]).run(4.0)
    first, row = marked(found, Quality.BEGUN_ANEW)
    assert first == 0
    assert marked(found, Quality.GAP_BEFORE) == [row]


@pytest.mark.parametrize(
    ("changes", "flag"),
    [
        ({"valid_until": "2026-01-01T00:00:00Z"}, Quality.CALIBRATION_DOUBTED),
        ({"status": "measured"}, Quality.CALIBRATION_DOUBTED),
        ({"temperature_range_c": [-20.0, 0.0]}, Quality.TEMPERATURE_OUTSIDE),
        ({"effects": [{"name": "nobody.knows", "coefficients": {}, "unit": "g"}]}, Quality.EFFECT_LEFT_IN),
    ],
)
def test_what_is_against_the_calibration_is_reported_of_every_sample(
    changes: dict[str, Any], flag: Quality
) -> None:
    found = LiveRig(calibration={**calibration_of(UNIT), **changes}).run(2.0)
    assert set((found.flags & ~np.uint32(FREE)).tolist()) == {int(flag)}


def test_a_count_at_the_end_of_the_format_is_saturated() -> None:
    period = 6.9 / np.abs(UNIT.accel_k).max()  # so that gravity counts 6 or 7 a sample
    rig = LiveRig(count_bits=4, truth=replace(UNIT, sample_period_s=round(float(period), 6)))
    found, sent = rig.run(2.0), rig.sent()
    assert isinstance(sent, CountBlock)
    rows = np.searchsorted(sent.device_time, found.t)
    largest = np.abs(np.hstack((sent.accel, sent.gyro)))[rows].max(axis=1)
    full = np.flatnonzero(largest >= 7).tolist()  # 2^3 - 1
    assert 0 < len(full) < len(found)
    assert marked(found, Quality.SATURATED) == full


def test_a_device_without_clock_and_name_is_reported_as_such() -> None:
    found = LiveRig(format="ch70").run(10.0)
    assert {"time_by_host", "unit_unknown"} <= set(names(int(found.flags[-1])))
    assert np.diff(found.t[-100:]) == pytest.approx(UNIT.sample_period_s, rel=0.2)


def test_utc_is_that_of_the_moment_at_which_a_sample_was_taken() -> None:
    offset = 1.8e9
    rig = LiveRig(utc=lambda host_ns: host_ns / 1e9 + offset)  # the station's clock is the device's here
    found = rig.run(4.0)
    assert np.abs(found.utc - (found.t + offset)).max() < 1e-6
    assert len(marked(found, Quality.UTC_BY_MESSAGES)) == len(found)


def test_a_sample_that_the_calibration_cannot_undo_is_nan_and_flagged_and_the_stream_goes_on() -> None:
    calm = LiveRig().run(4.0)
    peak = float(np.degrees(np.abs(calm.omega)).max())
    size = {axis: {"value": 1 / (0.9 * peak)} for axis in "xyz"}  # no rate puts out more than 0.9 of the peak
    sine = {"name": "gyroscope.sagnac_sine", "coefficients": size}
    rig = LiveRig(calibration=calibration_of(UNIT) | {"effects": [sine]})
    found = rig.run(4.0)
    lost = np.isnan(found.omega).any(axis=1)
    assert len(found) == len(calm)
    assert 0 < lost.sum() < len(found) / 2
    assert marked(found, Quality.UNSETTLED) == np.flatnonzero(lost).tolist()
    assert rig.samples.unsettled == lost.sum()
    assert np.array_equal(found.f, calm.f)


EPOCH = 1_780_000_000.0  # s since 1970 at device time 0
LINK = 0.003  # s that the link adds to every read


def read_ns(t: float, late: float = 0.0) -> int:
    return round((EPOCH + t + LINK + late) * 1e9)


def test_nothing_gives_utc_and_moments_follow_the_reads_that_came_least_late() -> None:
    times = SampleTimes(None)
    rng = np.random.default_rng(1)
    for first in np.arange(0.0, 3.0, 0.01):
        t = first + np.array([0.001, 0.002, 0.003])
        taken, utc = times.of(t, read_ns(t[-1], rng.exponential(0.02)), None)
        assert np.isnan(utc).all()
    assert taken / 1e9 == pytest.approx(EPOCH + t + LINK, abs=0.005)
    assert not times.is_by_messages


def test_a_receiver_gives_utc_by_its_messages() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9 - 100.0)
    _, utc = times.of(np.array([1.0, 1.5]), read_ns(1.5), None)
    assert utc == pytest.approx(EPOCH + np.array([1.0, 1.5]) + LINK - 100.0, abs=1e-6)
    assert times.is_by_messages


def test_a_pulse_gives_utc_however_late_reads_are_and_its_end_is_seen() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9)
    rng = np.random.default_rng(2)
    for first in np.arange(0.25, 8.0, 0.1):
        t = first + np.array([0.0, 0.05])
        age = float(t[-1] % 1.0)  # a second of UTC begins with one of the device's here
        _, utc = times.of(t, read_ns(t[-1], rng.exponential(0.05)), age)
        assert utc == pytest.approx(EPOCH + t, abs=1e-6)
        assert not times.is_by_messages
    for first in np.arange(8.0, 14.0, 0.1):
        t = first + np.array([0.0, 0.05])
        _, utc = times.of(t, read_ns(t[-1]), None)
    assert times.is_by_messages
    assert utc == pytest.approx(EPOCH + t, abs=0.01)


def test_a_restart_of_the_device_forgets_which_second_its_pulses_were() -> None:
    times = SampleTimes(lambda host_ns: host_ns / 1e9)
    times.of(np.array([200.25]), read_ns(200.25), 0.25)
    times.reset()  # it counts from 0 again
    _, utc = times.of(np.array([2.25]), read_ns(202.25), 0.25)
    assert utc == pytest.approx(EPOCH + 202.25, abs=1e-6)

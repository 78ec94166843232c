"""A receiver that is late: velocities and fixes count at their own moment, by its latency or by a pulse."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.gnss_records import FixType, GnssFix
from station.attitude.live_kalman_filter import AidValues
from station.monitor import monitor
from station.monitor.auxiliary_inputs import USUAL_LATENCY, aiding_of
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DriveRig
from tests.station.monitor.test_driving import TRUTH

FLAT = replace(Truth.example(5), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))
LEVEL = bends(40.0, still=8.0)
LATE = AutopilotTruth(default_hz=5.0, latency_s=0.3)


def off_course(folder: Path) -> float:
    """Return the rms of the heading's error [deg] once the drive is under way."""
    folder.mkdir()
    rig = DriveRig(FLAT, LEVEL, LATE, folder=folder)
    rig.run(34.0)
    rig.monitor.close()
    assert rig.writer is not None
    rig.writer.close()
    found = [view.reading for view in rig.lines if view.reading is not None and view.reading.t > 18.0]
    east, north, _ = LEVEL.velocities(np.array([reading.t for reading in found])).T
    off = np.array([reading.heading for reading in found]) - np.degrees(np.arctan2(east, north))
    return float(np.sqrt(np.mean(((off + 180.0) % 360.0 - 180.0) ** 2)))


def test_what_a_late_receiver_says_counts_at_its_own_moment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    noticed = off_course(tmp_path / "told")

    def at_once(*given: object) -> AidValues:
        return replace(aiding_of(*given), age=0.0)  # type: ignore[arg-type]

    monkeypatch.setattr(monitor, "aiding_of", at_once)
    assert noticed < 1.0
    assert off_course(tmp_path / "at once") > 3 * noticed


@pytest.mark.parametrize(("latency", "expected"), [(0.25, 0.29), (None, USUAL_LATENCY + 0.04), (-1.0, 0.0)])
def test_the_age_of_a_fix_is_its_latency_and_what_passed_since(latency: float | None, expected: float) -> None:
    fix = GnssFix("GPS_RAW_INT", 1, 10**9, FixType.FIX_3D, latency=latency, speed=5.0, course=0.0)
    assert aiding_of([fix], "gnss", 10**9 + 40_000_000).age == pytest.approx(expected)


TRACK = bends(40.0, still=14.0)
LATE_S = 0.25  # of which nothing but a pulse tells: fixes are stamped with UTC, and read so much later
AUTOPILOT = AutopilotTruth(position_std_m=0.1, default_hz=5.0, latency_s=LATE_S, states_utc=True)
FASTER: Truth = replace(TRUTH, sample_period_s=0.008)


def late(format: str, *, pps: bool) -> float:
    """Return how late [s] the places are, by how far they lie back along the way; nan where nothing is located."""
    rig = DriveRig(FASTER, TRACK, AUTOPILOT, format=format, pps=pps, gives_time=False)
    rig.run(36.0)
    assert rig.feed.stamp is not None
    begun = rig.feed.stamp[1] - rig.source.device.imu.time
    found = [view.location for view in rig.lines if view.location and view.location.is_located]
    settled = [each for each in found if each.t - begun > 26.0]
    if len(settled) < 60:
        return np.nan
    t = np.array([each.t for each in settled]) - begun
    back = TRACK.positions(t)[:, :2] - TRACK.position(0.0)[:2] - np.array([each.enu[:2] for each in settled])
    v = TRACK.velocities(t)[:, :2]
    return float(np.mean(np.sum(back * v, axis=1) / np.sum(v * v, axis=1)))


@pytest.mark.parametrize("format", ["stim300", "rawimusx"])
def test_a_pulse_places_fixes_that_are_read_late(format: str) -> None:
    assert abs(late(format, pps=True)) < 0.03
    assert not late(format, pps=False) < 0.6 * LATE_S  # an alignment refuses what fits no motion

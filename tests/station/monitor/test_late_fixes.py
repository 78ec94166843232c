"""A level drive whose receiver is late: velocities count at their own moment."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.earth.gnss_records import FixType, GnssFix
from station.live_attitude.joint_filter import AidValues
from station.monitor import monitor
from station.monitor.gnss_aid import USUAL_LATENCY, aiding_of
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DriveRig

TRUTH = replace(Truth.example(5), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))
TRACK = bends(40.0, still=8.0)
LATE = AutopilotTruth(default_hz=5.0, latency_s=0.3)


def off_course(folder: Path) -> float:
    """Return the rms of the heading's error [deg] once the drive is under way."""
    folder.mkdir()
    rig = DriveRig(TRUTH, TRACK, LATE, folder=folder)
    rig.run(34.0)
    rig.monitor.close()
    assert rig.writer is not None
    rig.writer.close()
    found = [view.reading for view in rig.lines if view.reading is not None and view.reading.t > 18.0]
    east, north, _ = TRACK.velocities(np.array([reading.t for reading in found])).T
    off = np.array([reading.heading for reading in found]) - np.degrees(np.arctan2(east, north))
    return float(np.sqrt(np.mean(((off + 180.0) % 360.0 - 180.0) ** 2)))


def test_what_a_late_receiver_says_counts_at_its_own_moment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = off_course(tmp_path / "told")

    def at_once(*given: object) -> AidValues:
        return replace(aiding_of(*given), age=0.0)  # type: ignore[arg-type]

    monkeypatch.setattr(monitor, "aiding_of", at_once)
    assert told < 1.0
    assert off_course(tmp_path / "at once") > 3 * told


@pytest.mark.parametrize(("latency", "expected"), [(0.25, 0.29), (None, USUAL_LATENCY + 0.04), (-1.0, 0.0)])
def test_the_age_of_a_fix_is_its_latency_and_what_passed_since(latency: float | None, expected: float) -> None:
    fix = GnssFix("GPS_RAW_INT", 1, 10**9, FixType.FIX_3D, latency=latency, speed=5.0, course=0.0)
    assert aiding_of([fix], "gnss", 10**9 + 40_000_000).age == pytest.approx(expected)

"""A drive in memory whose IMU has a pulse a second: a late receiver's fixes count at their own moment, live."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import DriveRig
from tests.station.monitor.test_driving import TRUTH

TRACK = bends(40.0, still=14.0)
LATE_S = 0.25  # of which nothing but a pulse tells: fixes are stamped with UTC, and read so much later
AUTOPILOT = AutopilotTruth(position_std_m=0.1, default_hz=5.0, latency_s=LATE_S, states_utc=True)
FASTER: Truth = replace(TRUTH, sample_period_s=0.008)


def late(format: str, *, pps: bool) -> float:
    """Return how late [s] the places are, by how far they lie back along the way; nan where nothing is located."""
    rig = DriveRig(FASTER, TRACK, AUTOPILOT, format=format, pps=pps, tells_time=False)
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

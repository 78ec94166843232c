"""An effect that cannot be fitted is an effect that does not fit: whatever a solve takes, a diagnosis takes."""

import numpy as np
import pytest

from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign, DwellRecord, ProcedureSigma, Site
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.frames import rotation
from procedures.positions import face_normal, face_of

OFFSET = np.array([0.5, -0.6, 0.4])  # m/s2


def six_faces(seed: int, tilt_deg: float, heading_deg: float) -> Campaign:
    """A sensor of a phone's grade, held by hand on six faces, of whose headings nothing is known."""
    rng, dwells = np.random.default_rng(seed), list[DwellRecord]()
    for i, position in enumerate((1, 3, 5, 7, 9, 11)):
        held = rotation(np.radians(tilt_deg) * rng.standard_normal((1, 3)))[0]
        up = held @ face_normal(face_of(position))
        accel = 9.8 * up + OFFSET + 0.015 * rng.standard_normal((500, 3))
        t = 0.01 * np.arange(1, 501) + 10 * i
        series = RateSeries(t, None, accel, np.full(500, np.nan), 0.01)
        dwells.append(DwellRecord(f"dwell_{position:02d}", position, series))
    sigma = ProcedureSigma(heading=float(np.radians(heading_deg)))
    return Campaign("M", "S", False, Site(0.87, 9.81, 5e-4), tuple(dwells), (), sigma)


@pytest.mark.parametrize(("seed", "tilt_deg", "heading_deg"), [(0, 0.5, 45), (5, 8, 180)])
def test_six_faces_that_a_solve_takes_are_diagnosed_whatever_their_headings(
    seed: int, tilt_deg: float, heading_deg: float
) -> None:
    campaign = six_faces(seed, tilt_deg, heading_deg)
    assert solve([campaign]).accelerometer is not None
    assert diagnose([campaign]).solution.accelerometer is not None

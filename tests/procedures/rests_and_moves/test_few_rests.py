"""Ten attitudes give nine numbers, and nothing to judge them by: it must be said."""

import numpy as np
import pytest

from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.counts.sample_records import RateSeries
from tests.procedures.free_units import ups


@pytest.mark.parametrize(("attitudes", "is_said"), [(10, True), (12, True), (13, False), (24, False)])
def test_a_fit_without_redundancy_is_said(attitudes: int, is_said: bool) -> None:
    rng = np.random.default_rng(attitudes)
    scale, bias = np.array([0.99, 1.01, 1.02]), np.array([0.03, -0.02, 0.05])
    rests = []
    for i, up in enumerate(ups(rng, attitudes)):
        t = 10.0 * i + 0.01 * np.arange(1, 301)
        accel = scale * up + bias + 1e-3 * rng.standard_normal((300, 3))
        rests.append(RestRecord(f"rest {i}", None, RateSeries(t, None, accel, np.full(300, np.nan), 0.01)))
    found = solve([Campaign("M", "S", False, Site(0.8, 9.80665, 1e-3), (), (), rests=tuple(rests))])
    assert found.accelerometer is not None
    warned = [text for text in found.warnings if f"{attitudes} rests determine 9 numbers" in text]
    assert bool(warned) == is_said

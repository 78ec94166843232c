from dataclasses import replace

import numpy as np

from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import RestRecord
from procedures.diagnosis.checks_before_effects import check_campaigns
from procedures.frames import face_of
from tests.procedures.diagnosis.planted import planted, with_reference_time


def test_a_label_a_knock_and_the_clock_are_put_right_together() -> None:
    effects = {
        "placement.label": {"position": 2.0, "actual": 9.0},
        "disturbance.dwell": {"x": 0.03, "y": 0.02, "position": 7.0, "at_s": 12.0, "duration_s": 4.0, "hz": 7.3},
        "clock.rate": {"value": -400.0},
    }
    campaign = with_reference_time(planted(8, effects, 30.0, turns=True), -400.0, 8)
    found = check_campaigns([campaign])
    assert [each.effect for each in found.findings] == ["placement.label", "disturbance.dwell", "clock.rate"]
    assert {each.confidence for each in found.findings} == {"established"}
    assert found.settled == {"placement.label", "disturbance.dwell", "clock.rate"}
    got, expected = (
        solve(found.campaigns).accelerometer,
        solve([planted(8, dwell_s=30.0, turns=True)]).accelerometer,
    )
    assert got is not None
    assert expected is not None
    for mine, true in ((got.bias, expected.bias), (got.scale_factor, expected.scale_factor)):
        assert np.all(np.abs(mine.value - true.value) < 4 * np.hypot(mine.std, true.std))


def test_a_clean_campaign_is_left_as_it_is() -> None:
    campaign = planted(9, turns=True)
    found = check_campaigns([campaign])
    assert found.findings == ()
    assert found.campaigns[0].dwells == campaign.dwells
    assert "clock.rate" not in found.settled


def test_rests_on_known_faces_are_looked_at_in_the_first_position_of_each() -> None:
    campaign = planted(9)
    known = tuple(RestRecord(each.name, face_of(each.position), each.series) for each in campaign.dwells[:4])
    lying = RestRecord("lying", None, campaign.dwells[4].series)
    found = check_campaigns([replace(campaign, dwells=(), rests=(*known, lying))]).campaigns[0]
    assert [each.position for each in found.dwells] == [1, 1, 3, 3]
    assert [each.name for each in found.rests] == ["lying"]
    assert all(each.series.gyro is None for each in found.dwells)  # their heading is not known

"""A sequence too short for a calibration: what its rests and moves show by the units told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, SequenceRecord, Site
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.rotation_summary import moves_seen, rests_seen

PERIOD, REST, MOVE = 0.01, 500, 200
UNIT = {"accelerometer": 16384.0, "gyroscope": 131.0}


def sequence(turns: list[FloatArray], gyro_scale: float = 1.0, accel_scale: float = 1.0) -> Campaign:
    """Rests with moves between them, a rotation vector [deg] each, at an even pace; outputs in LSB of a MEMS."""
    rng = np.random.default_rng(4)
    C, rate, up = Rotation.identity(), list[FloatArray](), list[FloatArray]()
    for turn in [*turns, np.zeros(3)]:
        rate += [np.zeros((REST, 3))]
        up += [np.tile(C.inv().apply([0.0, 0.6, 0.8]), (REST, 1))]
        if turn.any():
            for _ in range(MOVE):
                C = C * Rotation.from_rotvec(np.radians(turn) / MOVE)
                up += [C.inv().apply([0.0, 0.6, 0.8])[None]]
            rate += [np.tile(turn / (MOVE * PERIOD), (MOVE, 1))]
    gyro = (
        np.concatenate(rate) * gyro_scale + [0.5, -1.0, 2.0] + 0.05 * rng.standard_normal((sum(map(len, rate)), 3))
    )
    accel = np.concatenate(up) * accel_scale + 1e-3 * rng.standard_normal((len(gyro), 3))
    moving = np.concatenate([np.full(len(part), bool(part.any())) for part in rate])
    accel[moving] += 0.05 * rng.standard_normal((int(moving.sum()), 3))  # hands
    t = PERIOD * np.arange(1, len(gyro) + 1)
    series = RateSeries(t, 131 * gyro, 16384 * accel, np.full(len(t), np.nan), PERIOD)
    site = Site(0.8, 9.80665, 0.02)
    return Campaign(
        "M", "S", False, site, (), (), sequences=(SequenceRecord("log.csv", series),), nominal_scale=UNIT
    )


def test_a_quarter_turn_is_seen_by_both_triads_and_they_agree() -> None:
    campaign = sequence([np.array([90.0, 0, 0]), np.array([0, 0, -30.0]), np.array([40.0, 40.0, 0])])
    first, second, third = moves_seen([campaign])
    assert first.turned == pytest.approx([90, 0, 0], abs=0.3)
    assert first.tilted == pytest.approx(90, abs=0.3)
    assert second.angle == pytest.approx(30, abs=0.3)
    assert third.angle == pytest.approx(np.hypot(40, 40), abs=0.3)
    assert all(move.apart is not None and move.apart < 0.3 for move in (first, second, third))


def test_a_wrong_scale_factor_shows_as_gravity_carried_too_far() -> None:
    (move,) = moves_seen([sequence([np.array([90.0, 0, 0])], gyro_scale=1.02)])
    assert move.angle == pytest.approx(91.8, abs=0.3)
    assert move.apart == pytest.approx(1.8, abs=0.3)


def test_rests_are_held_against_gravity() -> None:
    rests = rests_seen([sequence([np.array([90.0, 0, 0])], accel_scale=1.01)])
    assert len(rests) == 2
    assert [rest.excess for rest in rests] == pytest.approx([0.01, 0.01], abs=5e-4)


def test_without_units_nothing_is_reported_of_sizes() -> None:
    campaign = replace(sequence([np.array([90.0, 0, 0])]), nominal_scale={})
    assert moves_seen([campaign]) == []
    assert [rest.excess for rest in rests_seen([campaign])] == [None, None]

"""What fixes say of velocity: told, or of the vertical one by their heights, no better than the heights are."""

import numpy as np
import pytest

from procedures.frames import rotation
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.gnss_velocity import (
    CLIMB_RATE_STD,
    CLIMB_SPAN_S,
    GnssMeasurements,
    LeverArm,
    measurements,
)
from procedures.fusion.imu.preintegration import Preintegrated

RISE, STD, RATE = 0.5, 0.3, 5.0  # m/s, m, Hz


def climbing(seconds: float = 60.0, seed: int = 0) -> GnssFixes:
    t = np.arange(0.0, seconds, 1 / RATE)
    p = np.zeros((len(t), 3))
    p[:, 2] = RISE * t + np.random.default_rng(seed).normal(0, STD, len(t))
    v, of_each = np.tile([3.0, 0.0, np.nan], (len(t), 1)), np.ones(len(t))
    return GnssFixes(t, p, v, np.full(len(t), np.nan), STD * of_each, 0.1 * of_each)


def said(fixes: GnssFixes) -> GnssMeasurements:
    t = np.arange(-1.0, fixes.t[-1] + 1.0, 0.05)
    return measurements(fixes, ImuSeries(t, np.zeros((len(t), 3)), np.zeros((len(t), 3))))


def test_heights_say_how_fast_it_climbs_as_well_as_they_are_known() -> None:
    found = said(climbing())
    early = found.t < CLIMB_SPAN_S / 2
    assert np.all(np.isinf(found.v_std[early, 2]))
    late = found.t >= CLIMB_SPAN_S
    off = found.v_n[late, 2] - RISE
    expected = np.sqrt(CLIMB_SPAN_S * RATE) * np.hypot(np.sqrt(2) * STD / CLIMB_SPAN_S, CLIMB_RATE_STD)
    assert np.allclose(found.v_std[late, 2], expected, rtol=0.05)
    weight = found.v_std[late, 2] ** -2
    assert abs((weight * off).sum() / weight.sum()) < 4 / np.sqrt(weight.sum())
    assert np.allclose(found.v_n[:, 0], 3.0)
    assert np.allclose(found.v_std[:, 0], 0.1)


def test_an_antenna_swings_where_the_body_points_at_the_fix_seen_from_the_keyframe() -> None:
    """A body turns steadily by 0.3 rad up to the keyframe; the fix fell a quarter of it after the beginning."""
    omega_b, dt, since = np.array([1.0, -2.0, 2.0]), 0.1, 0.025
    none, square = np.zeros(3), np.zeros((9, 9))
    part = Preintegrated(
        dt, rotation(omega_b * dt), none, none, none, none, square[:, :6], square, np.array([0.0, dt]),
        np.zeros((2, 3)), np.zeros((2, 3)),
    )  # fmt: skip
    one = np.ones((1, 3))
    fixes = GnssMeasurements(np.array([since]), 0 * one, one, 0 * one, one, omega_b[None])
    fix = fixes.at_end(0.0, part, np.eye(3), none, LeverArm(none))
    C_1f = rotation(omega_b * (since - dt))  # from b at the fix to b at the keyframe
    lever = np.array([0.3, 1.0, -0.5])
    assert fix.swing @ lever == pytest.approx(C_1f @ np.cross(omega_b, lever), abs=0.3**2 / 8 * 3.5)
    assert fix.age == pytest.approx(since - dt)

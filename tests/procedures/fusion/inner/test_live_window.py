"""Keyframes added one by one give what a recording's window gives."""

from dataclasses import replace

import numpy as np

from procedures.fusion.alignment.alignment_attempts import align_when_possible, between
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from tests.procedures.fusion.motions import EARTH, GRAVITY, NO_LEVER, NOISE, Eight
from tests.procedures.fusion.seen import SITE


def test_a_window_that_is_lived_through_ends_where_the_recorded_one_does() -> None:
    flight, rng = Eight(14.0), np.random.default_rng(1)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng)
    aligned = align_when_possible(MovingAligner(NOISE, GRAVITY, EARTH, NO_LEVER), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    settings = WindowSettings(SITE, NO_LEVER)
    whole = InertialWindow(settings, imu, fixes, replace(aligned, t0=4.0))
    recorded = list(whole.poses())
    cut = int(np.searchsorted(fixes.t, 8.0))
    first = float(fixes.t[cut])
    live = InertialWindow(settings, between(imu, 0.0, first), fixes.part(slice(cut + 1)), replace(aligned, t0=4.0))
    begun = list(live.poses())
    for t in whole.frames.t[len(begun) :].tolist():
        last = live.go_on(t, between(imu, live.t - 0.1, t + 0.1), fixes)
    assert len(begun) > 50
    assert np.allclose(last.p_o, recorded[-1].p_o, atol=1e-6)
    assert np.allclose(last.C_ob, recorded[-1].C_ob, atol=1e-8)
    assert np.allclose(last.drift, recorded[-1].drift)
    assert 0 < last.own_yaw_std < np.radians(3.0)
    assert np.isclose(last.own_yaw_std, recorded[-1].own_yaw_std)

"""Keyframes added one by one give what a recording's window gives."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.fusion.alignment_attempts import align_when_possible, between
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.fusion_records import AlignmentState
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.inner.window_state import FRAME_SPACING_S, MIN_FRAME_SPACING_S, Frame, filled
from procedures.fusion.vision.visual_alignment import VisualStart, align_by_camera
from tests.drivers.simulated.camera_tracks import View
from tests.procedures.fusion.motions import CAMERA, EARTH, GRAVITY, NO_LEVER, NOISE, SITE, Eight, tracks_of


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


# Frames of a camera that are added one by one give what a recording's window gives


SETTINGS = VisionSettings(SITE, CAMERA, LeverArm(np.zeros(3)))


@pytest.mark.proof
def test_a_visual_window_that_is_lived_through_ends_where_the_recorded_one_does() -> None:
    flight, rng = Eight(9.0), np.random.default_rng(1)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng)
    tracks = tracks_of(flight, 3, view=View(features=60, longest=6.0))
    dark = (tracks.t > 6.0) & (tracks.t < 6.5)
    tracks = FeatureTracks(tracks.t[~dark], tracks.feature[~dark], tracks.uv[~dark])
    found = align_by_camera(SETTINGS, imu, tracks, fixes)
    assert isinstance(found, VisualStart)
    start = found.aligned
    whole = VisualInertialWindow(SETTINGS, imu, tracks, fixes, start)
    recorded = list(whole.poses())
    t, begin = tracks.frames()
    cut = int(np.searchsorted(t, 5.0))
    early = tracks.t < t[cut]
    first = FeatureTracks(tracks.t[early], tracks.feature[early], tracks.uv[early])
    known = between(imu, 0.0, float(t[cut - 1]))
    live = VisualInertialWindow(SETTINGS, known, first, fixes.part(fixes.t < t[cut]), start)
    poses = list(live.poses())
    assert poses[-1].t < t[cut]
    for i in range(cut, len(t)):
        if t[i] - live.t < MIN_FRAME_SPACING_S:
            continue
        rows = slice(int(begin[i]), int(begin[i + 1]))
        for frame in filled(live.t, Frame(float(t[i]), tracks.feature[rows], tracks.uv[rows])):
            poses.append(live.go_on(frame, between(imu, live.t - 0.1, frame.t + 0.1), fixes))
    upto = len(poses)
    assert np.allclose([pose.t for pose in poses], [pose.t for pose in recorded[:upto]])
    assert max(np.diff([pose.t for pose in poses])) < 1.5 * FRAME_SPACING_S
    assert np.allclose(poses[-1].p_o, recorded[upto - 1].p_o, atol=1e-6)
    assert np.allclose(poses[-1].C_ob, recorded[upto - 1].C_ob, atol=1e-8)
    assert np.allclose(poses[-1].drift, recorded[upto - 1].drift)
    assert np.linalg.norm(live.velocity - flight.v(np.array(live.t))) < 0.3

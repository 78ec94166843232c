"""Where a body is that flies an eight and has a camera: joint alignment and window, to the last pose."""

import numpy as np

from procedures.fusion.imu.gnss_velocity import LeverArm
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner, align_by_camera
from procedures.fusion.visual_alignment.visual_start import VisualStart
from tests.drivers.simulated.camera_tracks import View
from tests.procedures.fusion.motions import EARTH, Eight
from tests.procedures.fusion.seen import CAMERA, SITE, tracks_of
from tests.stored.held import assert_held

ZERO = np.zeros(3)


def test_a_window_with_a_camera() -> None:
    flight = Eight(8.0)
    imu, fixes = flight.imu(np.random.default_rng(1), EARTH), flight.fixes(np.random.default_rng(2))
    tracks = tracks_of(flight, 3, view=View(features=80, longest=6.0))
    settings = VisionSettings(SITE, CAMERA, LeverArm(ZERO))
    start = align_by_camera(VisualAligner(settings), imu, tracks, fixes)
    assert isinstance(start, VisualStart)
    poses = list(VisualInertialWindow(settings, imu, tracks, fixes, start.aligned).poses())
    assert_held("positions", "camera", [start, poses[::5]])

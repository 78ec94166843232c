"""A rolling shutter: tracks simulated row by row along a planted flight, with the row time told and not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera, derotated
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.vision.visual_alignment import VisualStart, align_by_camera
from tests.drivers.simulated.camera_tracks import View
from tests.procedures.fusion.motions import CAMERA, EARTH, SITE, Eight, tracks_of

ROW = 60e-6  # s: 29 ms an image
ROLLING = replace(CAMERA, row_time=ROW)
SECONDS = 11.0
VIEW = View(features=80, longest=6.0, outliers=0.0)
ZERO = np.zeros(3)


@pytest.fixture(scope="module")
def flight() -> Eight:
    return Eight(SECONDS)


@pytest.fixture(scope="module")
def imu(flight: Eight) -> ImuSeries:
    return flight.imu(np.random.default_rng(1), EARTH)


@pytest.fixture(scope="module")
def fixes(flight: Eight) -> GnssFixes:
    return flight.fixes(np.random.default_rng(2)).part(slice(0, None, 4))


@pytest.fixture(scope="module")
def tracks(flight: Eight) -> FeatureTracks:
    return tracks_of(flight, 3, replace(ROLLING, std=0.3), VIEW)


def located(
    imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, camera: PinholeCamera, flight: Eight
) -> tuple[float, float, int]:
    """Return errors of the step over a second [m rms], tilt [deg rms], and how many sights were rejected."""
    settings = VisionSettings(SITE, replace(camera, std=0.3), LeverArm(ZERO))
    start = align_by_camera(replace(settings, camera=replace(camera, std=1.0)), imu, tracks, fixes)
    assert isinstance(start, VisualStart), start
    window = VisualInertialWindow(settings, imu, tracks, fixes, start.aligned)
    poses = [(pose.t, pose.p_o, pose.C_ob) for pose in window.poses()]
    t, p = np.array([each[0] for each in poses]), np.array([each[1] for each in poses])
    steps = (p[10:] - p[:-10]) - (flight.p(t[10:]) - flight.p(t[:-10]))
    up = np.array([each[2][2] for each in poses])
    true_up = flight.attitude(t).as_matrix()[:, 2]
    tilt = np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", up, true_up), -1, 1)))
    late = t[10:] > 5.0
    return float(np.sqrt((steps[late] ** 2).sum(axis=1).mean())), float(np.sqrt((tilt**2).mean())), window.rejected


@pytest.mark.proof
def test_the_row_time_takes_the_error_of_a_rolling_shutter_away(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    reported = located(imu, tracks, fixes, ROLLING, flight)
    unreported = located(imu, tracks, fixes, CAMERA, flight)
    at_once = located(imu, tracks_of(flight, 3, replace(CAMERA, std=0.3), VIEW), fixes, CAMERA, flight)
    assert reported[0] < 0.25 * unreported[0]
    assert reported[0] < 2.0 * at_once[0]
    assert reported[1] < 1.1 * at_once[1]
    assert reported[2] < 0.1 * unreported[2]


@pytest.mark.parametrize("newest_s", [0.1, 0.0])
def test_what_a_turning_camera_sees_is_derotated_to_where_it_would_have_stood(newest_s: float) -> None:
    """A camera turns on the spot before points far away; each row's projection is by its own attitude."""
    rate = np.array([0.6, -0.9, 0.4])
    rng, camera = np.random.default_rng(5), replace(ROLLING, t_bc=ZERO)
    uv = rng.uniform([0, 0], [752, 480], (200, 2))
    rays = np.column_stack((camera.rays(uv), np.ones(200)))

    def C_nc(t: np.ndarray) -> np.ndarray:
        return Rotation.from_rotvec(np.outer(t, rate)).as_matrix() @ camera.C_bc

    far = np.einsum("nij,nj->ni", C_nc(ROW * (uv[:, 1] - camera.cy)), rays)
    at_once = far @ C_nc(np.zeros(1))[0]
    due = camera.pixels(at_once[:, :2] / at_once[:, 2:])
    t = np.arange(-40, 1) * 0.005 + newest_s  # of a live image the IMU's newest sample is as old as the image
    imu = ImuSeries(t, np.tile(rate, (len(t), 1)), np.zeros((len(t), 3)))
    found = derotated(FeatureTracks(np.zeros(200), np.arange(200), uv), imu, camera)
    assert np.abs(uv - due).max() > 5.0
    assert np.abs(found.uv - due).max() < 0.02
    assert derotated(FeatureTracks(np.zeros(200), np.arange(200), uv), imu, CAMERA).uv is uv

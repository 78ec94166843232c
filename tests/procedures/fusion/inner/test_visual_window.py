"""The visual-inertial window and its start follow a planted flight, judged by their own sigma."""

from functools import cache

import numpy as np
import pytest

from procedures.frames import rotation_vector
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import GnssFixes, ImuSeries, Waiting, WheelMount, WheelSpeeds
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.pose_graph import PoseGraph
from procedures.fusion.vision.visual_alignment import VisualStart, align_at, align_by_camera
from tests.drivers.simulated.camera_tracks import View
from tests.procedures.fusion.motions import ACCEL_BIAS, CAMERA, EARTH, GYRO_BIAS, SITE, Eight, tracks_of, turned

ZERO = np.zeros(3)
SECONDS = 11.0
VIEW = View(features=80, longest=6.0)


@pytest.fixture(scope="module")
def flight() -> Eight:
    return Eight(SECONDS)


@pytest.fixture(scope="module")
def imu(flight: Eight) -> ImuSeries:
    return flight.imu(np.random.default_rng(1), EARTH)


@pytest.fixture(scope="module")
def fixes(flight: Eight) -> GnssFixes:
    return flight.fixes(np.random.default_rng(2))


@pytest.fixture(scope="module")
def tracks(flight: Eight) -> FeatureTracks:
    return tracks_of(flight, 3, view=VIEW)


@cache
def begun(imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, camera: PinholeCamera = CAMERA) -> VisualStart:
    found = align_by_camera(VisionSettings(SITE, camera, LeverArm(ZERO)), imu, tracks, fixes)
    assert isinstance(found, VisualStart), found
    return found


def window(
    imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, camera: PinholeCamera = CAMERA
) -> VisualInertialWindow:
    start = begun(imu, tracks, fixes).aligned
    return VisualInertialWindow(VisionSettings(SITE, camera, LeverArm(ZERO)), imu, tracks, fixes, start)


def turn_of(C_nb: np.ndarray, flight: Eight, t: float) -> np.ndarray:
    """Return the error (3,) of an attitude about East, North and up [deg]."""
    return np.degrees(rotation_vector(C_nb @ flight.attitude(np.array(t)).as_matrix().T))


def test_the_joint_fit_knows_scale_and_attitude_to_its_own_sigma(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    settings, found = VisionSettings(SITE, CAMERA, LeverArm(ZERO)), list[VisualStart]()
    for now in np.arange(2.0, 10.0, 1.0):
        if isinstance(each := align_at(settings, imu, tracks, fixes, float(now)), VisualStart):
            found.append(each)
    assert len(found) >= 5
    lengths = [np.linalg.norm(flight.p(each.t[-1:]) - flight.p(each.t[:1])) for each in found]
    rough, refined = (
        np.array([np.linalg.norm(way[-1] - way[0]) / true - 1 for way, true in zip(ways, lengths, strict=True)])
        for ways in ([each.rough for each in found], [each.refined for each in found])
    )
    assert np.abs(refined).max() < 0.03
    assert np.abs(rough).max() < 0.1
    assert np.all(np.abs(refined) < 4 * np.array([each.scale_std for each in found]))
    for each in found:
        east, north, up = np.radians(turn_of(each.aligned.C_now, flight, each.aligned.t))
        assert np.hypot(east, north) < 4 * each.aligned.tilt_std
        assert abs(up) < 4 * each.aligned.yaw_std


def test_the_start_waits_for_displacement_and_says_so(tracks: FeatureTracks) -> None:
    flight = Eight(6.0, still=6.0)
    still = tracks_of(flight, 3)
    rng = np.random.default_rng(1)
    found = align_by_camera(
        VisionSettings(SITE, CAMERA, LeverArm(ZERO)),
        flight.imu(rng, EARTH),
        still,
        flight.fixes(rng),
    )
    assert isinstance(found, Waiting)
    assert "move further" in found.why


@pytest.mark.proof
def test_the_window_follows_the_flight_and_the_graph_stays_within_its_sigma(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    source = window(imu, tracks, fixes)
    poses = [pose for pose in PoseGraph().run(source, fixes) if pose.t > 5.0]
    error = np.array([pose.p - flight.p(np.array(pose.t)) for pose in poses])
    assert np.linalg.norm(error, axis=1).mean() < 0.06
    sigma = np.array([np.sqrt(np.diag(pose.covariance)[:3]) for pose in poses])
    assert 0.1 < np.mean((error / sigma) ** 2) < 2.5
    turn = np.array([turn_of(pose.C_nb, flight, pose.t) for pose in poses])
    assert np.hypot(turn[:, 0], turn[:, 1]).max() < 1.0
    assert np.sqrt(np.mean(turn[:, 2] ** 2)) < 1.0
    assert np.abs(source.state.bg[-1] - GYRO_BIAS).max() < 1e-3
    assert np.abs(source.state.ba[-1] - ACCEL_BIAS).max() < 0.05
    wrong = 0.02 * len(tracks.t)  # that were displaced
    assert 0.5 * wrong < source.rejected < 3.0 * wrong


def test_where_the_camera_sits_is_found(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    reported = turned(CAMERA, 0.6, 0.01)
    source = window(imu, tracks, fixes, reported)
    list(source.poses())
    off = np.degrees(rotation_vector(CAMERA.C_bc.T @ source.state.C_bc))
    assert np.linalg.norm(off) < 0.25 * np.linalg.norm(np.degrees(rotation_vector(CAMERA.C_bc.T @ reported.C_bc)))


def test_without_gnss_it_drifts_by_centimetres(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    early = fixes.part(fixes.t < 4.5)
    source = window(imu, tracks, early)
    poses = [pose for pose in PoseGraph().run(source, early) if pose.t > 4.0]
    error = np.array([pose.p - flight.p(np.array(pose.t)) for pose in poses])
    size = np.linalg.norm(error - error[0], axis=1)
    assert size.max() < 0.25  # 6.5 s, some 12 m of flight
    sigma = np.array([np.sqrt(np.diag(pose.covariance)[:3]) for pose in poses])
    assert sigma[-1].min() > sigma[0].min()
    assert np.all(np.abs(error[-1]) < 4 * sigma[-1])


def test_an_offset_left_in_the_cameras_stamps_is_found_by_the_window(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    start = begun(imu, tracks, fixes).aligned
    settings = VisionSettings(SITE, CAMERA, LeverArm(ZERO), offset_std=0.02)
    source = VisualInertialWindow(settings, imu, tracks.shifted(0.015), fixes, start)
    poses = [pose for pose in PoseGraph().run(source, fixes) if pose.t > 5.0]
    assert abs(source.state.offset + 0.015) < 4 * source.offset_std < 0.02
    turn = np.array([turn_of(pose.C_nb, flight, pose.t) for pose in poses])
    assert np.hypot(turn[:, 0], turn[:, 1]).max() < 1.0


@pytest.mark.proof
def test_a_wheel_with_the_camera_is_found_to_its_scale(
    flight: Eight, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> None:
    """It tells the speed along an axis of the body, as any log or wheel does, 2 % too little."""
    t = np.arange(0.0, SECONDS, 0.05)
    forward, lever = np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.0, -0.2])

    def place(at: np.ndarray) -> np.ndarray:
        return flight.p(at) + flight.attitude(at).apply(lever)

    v_n = (place(t + 1e-3) - place(t - 1e-3)) / 2e-3
    speed = flight.attitude(t).inv().apply(v_n) @ forward / 1.02 + np.random.default_rng(4).normal(0, 0.03, len(t))
    wheel = WheelAid(WheelMount(forward, lever, 0.03, 0.1, is_signed=True), WheelSpeeds(t, speed), SITE.noise)
    start, settings = begun(imu, tracks, fixes).aligned, VisionSettings(SITE, CAMERA, LeverArm(ZERO))
    seeing = VisualInertialWindow(settings, imu, tracks, fixes, start, wheel)
    list(seeing.poses())
    assert seeing.wheel_std < 0.01
    assert abs(seeing.state.wheel - 0.02) < 3.5 * seeing.wheel_std
    assert seeing.wheel is not None
    assert not seeing.wheel.slips

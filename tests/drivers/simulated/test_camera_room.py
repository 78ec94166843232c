"""Images of the simulated camera are those of its pose: features move where true projections have them."""

import tomllib

import numpy as np
import pytest

from drivers.errors import TruthRefused
from drivers.simulated.bench_in_memory import world_with_effects
from drivers.simulated.companions.camera_server import CameraImages
from drivers.simulated.companions.truths import CameraTruth, camera_toml
from drivers.simulated.faults import TimedFault
from drivers.simulated.imu import Z_UP_POSITION
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import drive
from procedures.frames import rotation
from procedures.fusion.vision.feature_tracker import FeatureTracker, FeatureTrackerSettings, LensModel
from tests.drivers.simulated.drives import bends

cv2 = pytest.importorskip("cv2", reason="opencv is not installed")
TRUTH, TRACK = Truth.example(3), bends(60.0)
CAMERA = CameraTruth()
LENS = LensModel(CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, np.zeros(4))
SETTINGS = FeatureTrackerSettings(features=90, apart=12.0)


def seen_again(images: CameraImages, t0: float, uv: np.ndarray, t: float) -> np.ndarray:
    """Return where what stands at points (n, 2) of the image at t0 is seen at t; nan where it is hidden then."""
    places = images.room.ends(CAMERA, *images.pose(t0), uv)
    C_nc, p_c = images.pose(t)
    y = (places - p_c) @ C_nc
    again = (y / y[:, 2:] @ CAMERA.K.T)[:, :2]
    behind = np.linalg.norm(images.room.ends(CAMERA, C_nc, p_c, again) - places, axis=1) > 0.2
    again[behind] = np.nan
    return again


def offsets(images: CameraImages, begin: float, seconds: float) -> tuple[np.ndarray, list[int]]:
    """Return how far (n,) [px] features are from where their first sight has them, and how many there were."""
    follower, first = FeatureTracker(LENS, SETTINGS), dict[int, tuple[float, np.ndarray]]()
    off, kept = list[np.ndarray](), list[int]()
    for t in begin + np.arange(0.0, seconds, 1 / CAMERA.rate_hz):
        image = cv2.imdecode(np.frombuffer(images.jpeg(t), np.uint8), cv2.IMREAD_GRAYSCALE)
        feature, uv = follower.follow(image)
        for number, point in zip(feature.tolist(), uv, strict=True):
            t0, uv0 = first.setdefault(number, (t, point))
            if t > t0:
                off.append(np.linalg.norm(point - seen_again(images, t0, uv0[None], t)[0]))
        kept.append(len(feature))
    return np.array([each for each in off if np.isfinite(each)]), kept


@pytest.fixture(scope="module")
def images() -> CameraImages:
    return CameraImages(TRUTH, CAMERA, track=TRACK)


def test_features_are_followed_to_a_fifth_of_a_pixel(images: CameraImages) -> None:
    off, kept = (
        np.concatenate(each) for each in zip(*(offsets(images, t, 0.5) for t in (8.0, 30.0)), strict=True)
    )
    assert len(off) > 700
    assert np.median(off) < 0.2
    assert np.mean(off < 1.0) > 0.85  # next to a pillar's edge features go with what is nearer
    assert min(kept) > 60


def test_the_camera_turns_and_goes_with_the_imu() -> None:
    """As the segment has it by which the IMU feels the drive; and by its lever arm and mounting next to it."""
    fixed = CameraTruth(C_bc=np.eye(3), t_bc=np.array([0.3, -0.2, 0.1]))
    mounted, period = CameraImages(TRUTH, fixed, track=TRACK), TRUTH.sample_period_s
    driven = drive(TRACK, world_with_effects(TRUTH).attitude(Z_UP_POSITION), 0, period)
    assert driven.angle is not None
    assert driven.axis_b is not None
    for k in (0, 100, 731, 2500):
        C_nb, p = mounted.pose(k * period)
        expected = (rotation(-driven.angle[k] * driven.axis_b) @ driven.C_bn).T
        assert C_nb == pytest.approx(expected, abs=1e-9)
        assert p == pytest.approx(TRACK.position(k * period) + expected @ fixed.t_bc, abs=1e-9)
    C_nc, _ = CameraImages(TRUTH, CAMERA, track=TRACK).pose(10.0)
    assert C_nc == pytest.approx(mounted.pose(10.0)[0] @ CAMERA.C_bc, abs=1e-9)
    v = TRACK.velocity(10.0)
    assert mounted.pose(10.0)[0][:, 0] @ v == pytest.approx(np.linalg.norm(v), rel=1e-2)  # x ahead, but for slopes


def test_images_are_had_again_and_differ_by_their_seed() -> None:
    one, same, other = (CameraImages(TRUTH, CAMERA, track=TRACK, seed=seed) for seed in (1, 1, 2))
    assert one.part(9.0) == same.part(9.0) != other.part(9.0)


def test_every_image_fault_shows() -> None:
    faults = [TimedFault(kind, at_s=at) for at, kind in enumerate(("dark", "no_stamp", "cut"))]
    images = CameraImages(TRUTH, CAMERA, faults, TRACK)
    assert images.image(0.5).mean() < 10 < images.image(1.5).mean()
    assert b"X-Timestamp" not in images.part(1.5)
    assert b"X-Timestamp: %.6f" % CAMERA.stamp(2.5) in images.part(2.5)
    assert len(images.part(2.5)) < 0.6 * len(images.part(3.5))


@pytest.mark.parametrize("wrong", [{"C_bc": np.ones((3, 3))}, {"t_bc": np.zeros(2)}])
def test_a_mounting_that_cannot_be_is_refused(wrong: dict[str, np.ndarray]) -> None:
    with pytest.raises(TruthRefused):
        CameraTruth(**wrong)


def test_the_description_is_that_of_the_camera() -> None:
    reported = tomllib.loads(camera_toml(CAMERA, "camera:http://127.0.0.1:8080/stream"))
    assert (reported["format"], reported["url"]) == ("camera/1", "camera:http://127.0.0.1:8080/stream")
    assert [reported[name] for name in ("fx_px", "fy_px", "cx_px", "cy_px")] == [230.0, 230.0, 187.5, 119.5]
    T = np.array(reported["imu_from_camera"])
    assert np.array_equal(T[:3, :3], CAMERA.C_bc)
    assert T[:, 3].tolist() == [*CAMERA.t_bc, 1.0]

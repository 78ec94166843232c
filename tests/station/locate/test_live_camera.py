"""A live camera's frames: on the IMU's clock, late by what is found, and the keyframes they ask for."""

import numpy as np
import pytest

from drivers.camera import CameraImage
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.inner.window_state import FRAME_SPACING_S
from procedures.fusion.vision.camera_time import CameraTimeOffset
from station.locate.live_camera import LiveCamera
from station.stream.camera import FeaturePositions
from tests.procedures.fusion.motions import CAMERA
from tests.procedures.fusion.vision.test_camera_time import rocking, seen

LATE_S, CLOCK_S = 0.06, 1000.0


class Eye:
    """A camera of tracks that are there already, read `LATE_S` late; ``stamps`` of a clock of its own, or none."""

    def __init__(self, tracks: FeatureTracks, *, stamps: bool) -> None:
        self._tracks, self._stamps = tracks, stamps
        self.t, self._begin = tracks.frames()

    def image(self, i: int) -> CameraImage:
        taken = float(self.t[i])
        device_ns = round((taken * (1 + 2e-5) + CLOCK_S) * 1e9) if self._stamps else None
        return CameraImage(round((taken + LATE_S) * 1e9), device_ns, str(i).encode())

    def follow(self, image: CameraImage) -> FeaturePositions | None:
        if image.jpeg == b"spoilt":
            return None
        rows = slice(*self._begin[int(image.jpeg) : int(image.jpeg) + 2].tolist())
        return self._tracks.feature[rows], self._tracks.uv[rows]


def fed(live: LiveCamera, eye: Eye, until: float, first: int = 0) -> int:
    """Let time pass by tenths of a second up to ``until`` [s]; return the next image."""
    start = 0.1 if not first else float(eye.t[first])
    for now in np.arange(start, until, 0.1).tolist():
        live.mark([(round(now * 1e9), now)])
        come = [i for i in range(first, len(eye.t)) if eye.t[i] + LATE_S <= now]
        live.take([eye.image(i) for i in come], now)
        first = come[-1] + 1 if come else first
    return first


@pytest.mark.parametrize("stamps", [False, True], ids=["read", "stamped"])
def test_what_stamps_are_late_by_is_found(stamps: bool) -> None:
    imu, tracks = seen(rocking, offset=0.0)
    eye = Eye(tracks, stamps=stamps)
    live = LiveCamera(CAMERA, eye.follow)
    assert live.text == "no image yet"
    first = fed(live, eye, 1.9)  # it stands still
    assert live.is_due
    live.learn(imu)
    assert live.offset is None
    assert live.text == "its delay is not known: rotate it unevenly"
    assert live.why.startswith("its delay is not known: ")
    assert not len(live.tracks().t)
    first = fed(live, eye, 4.0, first)
    live.learn(imu)
    assert live.offset is not None
    assert abs(live.offset.offset + LATE_S) < 4 * live.offset.std
    assert not live.is_due
    assert live.offset_std > 0.01
    fed(live, eye, 11.5, first)
    assert live.text == f"120 features, stamps {-live.offset.offset * 1e3:.0f} ms late"
    live.fitted = 0.01
    assert live.text == f"120 features, stamps {-live.offset.offset * 1e3 - 10:.0f} ms late"
    assert np.abs(live.tracks(4.95).t[0] - eye.t[np.searchsorted(eye.t, 4.95)]) < 0.005
    assert live.lateness == pytest.approx(LATE_S + 0.06, abs=0.11)


def test_what_is_specified_is_kept() -> None:
    _, tracks = seen(rocking, offset=0.0)
    eye = Eye(tracks, stamps=False)
    live = LiveCamera(CAMERA, eye.follow, CameraTimeOffset(-LATE_S, 0.0))
    fed(live, eye, 3.0)
    assert not live.is_due
    assert live.offset_std == 0.0
    assert live.text == "120 features, stamps 60 ms late"
    live.reset()
    assert live.text == "no image yet"
    assert live.offset == CameraTimeOffset(-LATE_S, 0.0)


def test_keyframes_stand_at_frames_and_as_often_without() -> None:
    _, tracks = seen(rocking, offset=0.0)
    dark = (tracks.t > 4.05) & (tracks.t < 4.95)
    eye = Eye(FeatureTracks(tracks.t[~dark], tracks.feature[~dark], tracks.uv[~dark]), stamps=False)
    live = LiveCamera(CAMERA, eye.follow, CameraTimeOffset(-LATE_S, 0.0))
    fed(live, eye, 6.0)
    due = list(live.due(3.0, 5.55))
    t = np.array([each.t for each in due])
    assert 5.55 - 1.5 * FRAME_SPACING_S < t[-1] <= 5.55
    assert np.diff(t).max() < 1.5 * FRAME_SPACING_S
    empty = np.array([not len(each.feature) for each in due])
    assert np.all(empty == ((t > 4.05) & (t < 4.95)))
    assert not list(live.due(float(t[-1]), 5.55))


def test_images_that_are_none_are_passed_over() -> None:
    _, tracks = seen(rocking, offset=0.0)
    eye = Eye(tracks, stamps=False)
    live = LiveCamera(CAMERA, eye.follow, CameraTimeOffset(-LATE_S, 0.0))
    first = fed(live, eye, 2.0)
    before = len(live.tracks().t)
    live.take([CameraImage(round(2.05e9), None, b"spoilt")], 2.1)
    assert len(live.tracks().t) == before
    live.take([eye.image(first - 1)], 2.1)  # again, as after a gap
    assert len(live.tracks().t) == before
    live.take([], 6.0)
    assert live.text == "no image for 4 s"
    live.take([CameraImage(round(5.95e9), None, b"spoilt")], 6.1)
    assert live.text == "images are not JPEG, or their size differs from the first"
    live.take([], 8.2)
    assert live.text == "no image for 6 s"


def test_where_it_lags_keyframes_stand_where_frames_will_and_have_them_once_they_come() -> None:
    _, tracks = seen(rocking, offset=0.0)
    eye = Eye(tracks, stamps=False)
    live = LiveCamera(CAMERA, eye.follow, CameraTimeOffset(-LATE_S, 0.0))
    first = fed(live, eye, 4.0)
    due = list(live.due(4.0, 4.95, lags=True))
    assert not any(len(each.feature) for each in due)
    times = np.array([each.t for each in due])
    assert np.abs(times[:, None] - eye.t).min(axis=1).max() < 0.002
    assert np.diff(times).max() < 1.5 * FRAME_SPACING_S
    fed(live, eye, 4.6, first)
    late = list(live.late(times, times[0]))
    assert [each.t for each in late] == [t for t in times[1:] if t < 4.5]
    assert live.dropped == 0
    for each in late:
        at = int(np.abs(eye.t - each.t).argmin())
        feature, uv = eye.follow(eye.image(at))
        here = np.searchsorted(feature, each.feature)
        assert np.abs(each.uv - uv[here]).max() < 0.5
    fed(live, eye, 6.0, int(np.searchsorted(eye.t, 5.0)))
    assert list(live.late(np.array([6.2, 6.3]), 6.1)) == []
    assert live.dropped == 0  # all of them older than what has been seen
    assert list(live.late(np.array([6.2, 6.3]), 5.0)) == []


def test_points_between_two_frames_lie_between_theirs() -> None:
    numbers, uv = [np.array([1, 2, 3]), np.array([2, 3, 4])], np.arange(6.0).reshape(3, 2)
    taken = iter(zip(numbers, (uv, uv + 10.0), strict=True))
    live = LiveCamera(CAMERA, lambda image: next(taken), CameraTimeOffset(0.0, 0.0))
    live.mark([(i * 10**8, i / 10) for i in range(12)])
    live.take([CameraImage(1_000_000_000, None, b""), CameraImage(1_080_000_000, None, b"")], 1.1)
    (found,) = live.late(np.array([0.9, 1.02]), 0.9)
    assert found.feature.tolist() == [2, 3]
    assert found.uv == pytest.approx(np.array([[4.0, 5.0], [6.0, 7.0]]), abs=1e-3)

"""The camera of a recording as tracks: which images count, and when each was taken by the IMU's clock."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.companions.truths import CameraTruth, camera_toml
from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.vision.feature_tracker import LensModel
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC
from station.locate.tracks_from_images import follow_all
from station.stream.camera import recorded_tracks
from station.stream.reader import Chunk
from station.stream.reader.raw_recording import RawRecording
from tests.procedures.fusion.rendered import FOCAL, HEIGHT, WIDTH, Scene, frames

cv2 = pytest.importorskip("cv2", reason="opencv is not installed: the extra `camera`")
NS = 10**9
CAMERA = CameraTruth(width=WIDTH, height=HEIGHT, fx=FOCAL, fy=FOCAL, cx=WIDTH / 2, cy=HEIGHT / 2)
BEGIN_S, AHEAD_S = 50.0, 20.0  # of the first image by the station's clock; of the IMU's clock before it
MARKS = [(round(t * NS), t - AHEAD_S) for t in np.arange(49.0, 53.0, 0.1).tolist()]


@cache
def pictures() -> list[bytes]:
    """Return JPEG images, a tenth of a second apart."""
    return [
        cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()
        for _, image in frames(Scene(cv2), 0.7)
    ]


def part(jpeg: bytes, stamp_s: float | None) -> bytes:
    stamp = "" if stamp_s is None else f"X-Timestamp: {stamp_s:.6f}\r\n"
    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n{stamp}\r\n"
    return head.encode() + jpeg + b"\r\n"


def record(folder: Path, images: Sequence[tuple[float, bytes, float | None]]) -> None:
    """Write images as they came: when [s of the station's clock], what, and the camera's own stamp [s]."""
    failures = list[Exception]()
    recording = RawRecording(folder / "camera_session_1.mcap", {}, failures.append, CAMERA_RAW_TOPIC)
    for at, jpeg, stamp in images:
        recording.put(Chunk(round(at * NS), part(jpeg, stamp)))
    recording.close()
    assert not failures
    (folder / "camera.toml").write_text(camera_toml(CAMERA, "camera:http://127.0.0.1:1/stream"))


def tracks_of(folder: Path) -> FeatureTracks:
    found = recorded_tracks(folder, MARKS)
    assert found is not None
    return found.tracks


def times(tracks: FeatureTracks) -> FloatArray:
    return np.unique(tracks.t)


def test_features_are_those_of_the_images_at_the_moments_by_the_imus_clock(tmp_path: Path) -> None:
    record(tmp_path, [(BEGIN_S + 0.1 * i, jpeg, None) for i, jpeg in enumerate(pictures())])
    tracks = tracks_of(tmp_path)
    decoded = [cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE) for jpeg in pictures()]
    lens = LensModel(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, np.zeros(4))
    same = follow_all([(30.0 + 0.1 * i, each) for i, each in enumerate(decoded)], lens)
    assert tracks.t == pytest.approx(same.t, abs=1e-6)
    assert np.array_equal(tracks.feature, same.feature)
    assert np.array_equal(tracks.uv, same.uv)
    assert len(times(tracks)) == len(pictures())


def test_the_cameras_own_stamps_show_when_an_image_was_taken(tmp_path: Path) -> None:
    late = [0.0, 0.05, 0.0, 0.03, 0.0, 0.02, 0.0]
    record(
        tmp_path,
        [(BEGIN_S + 0.1 * i + late[i], jpeg, 7.0 + 0.1 * i) for i, jpeg in enumerate(pictures()[: len(late)])],
    )
    assert np.diff(times(tracks_of(tmp_path))) == pytest.approx([0.1] * 6, abs=2e-3)

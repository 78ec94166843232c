"""The camera of a recording as tracks on the IMU's clock."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from procedures.earth.gnss_records import TimeMark
from procedures.fusion.vision.feature_tracks import FeatureTracks
from station.files.fusion_folder.fusion_writing import CameraTracks
from station.files.fusion_folder.tracks import lens_of
from station.stream.camera.camera_feed import recorded_images
from station.stream.camera.description import CAMERA_FILE, read_description
from station.stream.camera.feature_following import ImageFeatureFollower
from station.stream.gnss.fix_times import FixTimes


def recorded_tracks(folder: Path, marks: Iterable[tuple[int, float]]) -> CameraTracks | None:
    """Return what the camera beside a recording saw; None where there was none.

    ``marks`` are moments of reading [ns] and the device times [s] of the samples that came then.

    Raises
    ------
    DataRefused
        If the camera's file or its bytes are damaged.
    ExtraMissing
        If OpenCV is not installed.
    """
    if not (folder / CAMERA_FILE).exists():
        return None
    table, times = read_description(folder / CAMERA_FILE).table, FixTimes(in_order=True)
    for host_ns, device_s in marks:
        times.mark_imu(host_ns, device_s)
    for image in recorded_images(folder):  # all of them, so that one line holds for all of a clock
        if image.device_ns is not None:
            times.mark_sender(TimeMark(image.host_ns, image.device_ns, None))
    return CameraTracks(_followed(folder, times, ImageFeatureFollower(lens_of(table))), table)


def _followed(folder: Path, times: FixTimes, follow: ImageFeatureFollower) -> FeatureTracks:
    t, feature, uv = [np.zeros(0)], [np.zeros(0, np.int64)], [np.zeros((0, 2))]
    newest = -np.inf
    for image in recorded_images(folder):
        now, seen = times.of(image), follow(image)
        if now is None or seen is None or not now > newest:
            continue
        newest = now
        t.append(np.full(len(seen[0]), now))
        feature.append(seen[0])
        uv.append(seen[1])
    return FeatureTracks(np.concatenate(t), np.concatenate(feature), np.concatenate(uv))

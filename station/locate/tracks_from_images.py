"""Tracks of a fusion folder from images: a folder of them with ``images.csv``, a camera, or a video file.

Images are grey. A device's images (Video4Linux 2) carry the kernel's own stamp, seconds of the monotonic clock; a
file's the time since its start.
"""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

import numpy as np

from drivers.errors import LinkLost, PortNotFound
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.vision.feature_tracker import FeatureTracker, Image, LensModel
from procedures.optional_libraries import opencv
from station.errors import DataRefused
from station.files.atomic_file import refuse_own
from station.files.fusion_folder.fusion_reading import FUSION_TOML, files_of, read_fusion_toml
from station.files.fusion_folder.fusion_tables import lens_of, write_tracks
from station.files.opening import open_inside

S_PER_MS = 1e-3  # s


def camera_images(path: str | Path, seconds: float = float("inf")) -> Iterator[tuple[float, Image]]:
    """Yield time [s] and image (h, w) of a camera or a video file until it ends or ``seconds`` have passed.

    Raise `PortNotFound` if there is none, `LinkLost` if a camera gives no more images, and `ExtraMissing` if
    OpenCV is not installed.
    """
    cv: Any = opencv()
    is_device = Path(path).is_char_device()
    # no options for a device: Video4Linux's backend refuses to open where it lacks one, such as a timeout
    capture = cv.VideoCapture(str(path), cv.CAP_V4L2 if is_device else cv.CAP_ANY)
    if not capture.isOpened():
        raise PortNotFound(str(path), "no images can be had", "name a camera such as /dev/video0 or a video file")
    with ExitStack() as opened:
        opened.callback(capture.release)
        first: float | None = None
        while (found := capture.read())[0]:
            t = float(capture.get(cv.CAP_PROP_POS_MSEC)) * S_PER_MS
            first = t if first is None else first
            if t - first > seconds:
                return
            image = found[1]
            yield t, cast("Image", image if image.ndim == 2 else cv.cvtColor(image, cv.COLOR_BGR2GRAY))
        if is_device:
            raise LinkLost(str(path), "it gives no more images")


LIST = "images.csv"
HEADER = "t_s,file"


def make_tracks(folder: Path, images: Path, seconds: float) -> Path:
    """Follow features through ``images`` and write the tracks that ``[tracks]`` of ``folder`` names.

    Raise `DataRefused` if the folder has no ``[tracks]`` with intrinsics, or an image cannot be read, and
    `CannotWrite` if the tracks would be written over an image or another file of the folder.
    """
    table = read_fusion_toml(folder)[0].tracks
    if table is None:
        raise DataRefused(folder / FUSION_TOML, None, "no [tracks]", "one, with file and intrinsics", "add it")
    if Path(table.file).name != table.file:
        raise DataRefused(
            folder / FUSION_TOML, None, f"file {table.file!r}", "the name of a file in the folder itself"
        )
    made = folder / table.file
    refuse_own((made,), [*files_of(folder, but="tracks"), *images_of(images)])
    pairs = listed_images(images, seconds) if images.is_dir() else camera_images(images, seconds)
    tracks = follow_all(pairs, lens_of(table))
    if not len(tracks.t):
        raise DataRefused(images, None, "no feature to follow", "images with corners")
    write_tracks(made, tracks)
    return made


def images_of(images: Path) -> list[Path]:
    """Return the files that are read where ``images`` is a folder of them, or a video."""
    if not images.is_dir():
        return [images]
    return [images / LIST, *(images / name for _, _, name in _lines(images))]


def follow_all(pairs: Iterable[tuple[float, Image]], lens: LensModel) -> FeatureTracks:
    """Return the tracks of features through images in the order of time, without the lens's distortion."""
    follower = FeatureTracker(lens)
    t, features, points = list[float](), [np.zeros(0, np.int64)], [np.zeros((0, 2))]
    for now, image in pairs:
        feature, uv = follower.follow(image)
        t.extend([now] * len(feature))
        features.append(feature)
        points.append(lens.straightened(uv))
    return FeatureTracks(np.array(t), np.concatenate(features), np.concatenate(points))


def listed_images(folder: Path, seconds: float = float("inf")) -> Iterator[tuple[float, Image]]:
    """Yield time [s] and grey image of each line ``t_s,file`` of the folder's ``images.csv``."""
    cv, shape, first = opencv(), None, None
    for number, t, name in _lines(folder):
        first = t if first is None else first
        if t - first > seconds:
            return
        with open_inside(folder, name, folder / LIST, number) as stream:
            image = cv.imdecode(np.frombuffer(stream.read(), np.uint8), cv.IMREAD_GRAYSCALE)
        if image is None:
            raise DataRefused(folder / LIST, number, f"{name!r}, which is no image", "PNG, JPEG or PGM")
        if shape is not None and image.shape != shape:
            raise DataRefused(folder / LIST, number, f"an image of {image.shape}", f"{shape} as those before it")
        shape = image.shape
        yield t, image


def _lines(folder: Path) -> Iterator[tuple[int, float, str]]:
    with open_inside(folder, LIST, folder, None) as stream:
        lines = stream.read().decode("utf-8", "backslashreplace").splitlines()
    if not lines or lines[0].strip() != HEADER:
        raise DataRefused(folder / LIST, 1, repr(lines[0][:40] if lines else ""), f"the header {HEADER}")
    before = -np.inf
    for number, line in enumerate(lines[1:], start=2):
        cell, _, name = line.partition(",")
        try:
            t = float(cell)
        except ValueError:
            t = np.nan
        if not np.isfinite(t) or not name.strip():
            raise DataRefused(folder / LIST, number, repr(line[:60]), f"a time and a file name: {HEADER}")
        if not t > before:
            raise DataRefused(
                folder / LIST, number, f"t_s {t:.6f} after {before:.6f}", "a time above the one before"
            )
        before = t
        yield number, t, name.strip()

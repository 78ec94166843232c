"""A camera alongside the IMU: its file `camera/1`, its images, and the features followed through them.

`camera/1` says where the camera is, its lens, and how it is mounted on the IMU. Images and tracks of a recording
are put on the IMU's clock.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import CameraAddress, HttpCameraAddress, VideoDeviceAddress
from drivers.camera import CameraDecoder, CameraImage
from drivers.errors import BadDeviceUrl
from procedures.arrays import FloatArray, IntArray
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.vision.feature_tracker import FeatureTracker, Image, LensModel
from procedures.gnss_records import TimeMark
from procedures.optional_libraries import opencv
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_schema import LensTable
from station.files.fusion_folder.fusion_tables import lens_of
from station.files.fusion_folder.fusion_writing import CameraTracks
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC
from station.files.toml_file import line_of, read_tables, read_text_file
from station.stream.auxiliary import DecodedCompanion, recorded_readings
from station.stream.gnss_fix_times import FixTimes
from station.stream.reader.reader import RestartingReader
from station.text import plural

FeaturePositions = tuple[IntArray, FloatArray]
Follow = Callable[[CameraImage], FeaturePositions | None]


class ImageFeatureFollower:
    """Call it with each image in turn; ``spoilt`` counts those that are none, or of another size."""

    def __init__(self, lens: LensModel) -> None:
        self._lens, self._cv = lens, opencv()
        self._follower = FeatureTracker(lens)
        self._shape: tuple[int, ...] | None = None
        self.spoilt = 0

    def __call__(self, image: CameraImage) -> FeaturePositions | None:
        """Return the features (n,) in an image and where they stand (n, 2) [px]; None where it is no image."""
        grey = self._cv.imdecode(np.frombuffer(image.jpeg, np.uint8), self._cv.IMREAD_GRAYSCALE)
        if grey is None or (self._shape is not None and grey.shape != self._shape):
            self.spoilt += 1
            return None
        self._shape = grey.shape
        feature, uv = self._follower.follow(cast("Image", grey))
        return feature, self._lens.straightened(uv)


CAMERA_FILE = "camera.toml"  # in a folder that is recorded


class CameraTable(LensTable):
    """All of it; what the stamps are off by is found where nothing is stated of it."""

    format: Literal["camera/1"]
    url: str


@dataclass(frozen=True, slots=True, eq=False)
class CameraDescription:
    """A camera's file as it was read: ``content`` is what a recording keeps of it."""

    content: bytes
    table: CameraTable
    address: CameraAddress


def read_description(path: Path) -> CameraDescription:
    """Read a camera's file.

    Raise `DataRefused` if there is none, a key is missing, unknown or out of range, or its address is none of a
    camera.
    """
    content = read_text_file(path)
    table, lines = read_tables(content, path, CameraTable)
    try:
        address = parse_device_url(table.url, "camera")
    except BadDeviceUrl as error:
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), error.expected) from error
    if not isinstance(address, HttpCameraAddress | VideoDeviceAddress):
        expected = "camera:http://HOST:PORT/PATH or camera:/dev/videoN"
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), expected)
    return CameraDescription(content, table, address)


CAMERA_SESSION = "camera_session"
MAX_WAITING_IMAGES = 300  # images that are not taken


class CameraFeed(DecodedCompanion[CameraImage]):
    """One camera, read and decoded; call `advance` often."""

    def __init__(self, reader: RestartingReader, clock: Callable[[], float] = time.monotonic) -> None:
        self.decoder = CameraDecoder()
        counters = self.decoder.counters
        super().__init__(
            reader, MAX_WAITING_IMAGES, clock, self.decoder.feed, kind="camera", lacks="images; check the camera",
            unread="bytes hold no whole image, expected JPEG; check the camera's format and the link",
            faults=lambda: (counters.cut, counters.not_jpeg),
        )  # fmt: skip

    @property
    def summary(self) -> str:
        """What came, in a line."""
        counters = self.decoder.counters
        return (
            f"camera {self.address.name}: {plural(counters.images, 'image')}, {counters.cut} cut, "
            f"{counters.not_jpeg} no JPEG, {plural(counters.skipped_bytes, 'byte')} in no image"
        )


@contextmanager
def open_camera(
    described: CameraDescription, folder: Path, clock: Callable[[], float] = time.monotonic
) -> Iterator[CameraFeed]:
    """Read a camera by a process of its own while the ``with`` lasts; its files go to ``folder``.

    ``camera_session_*.mcap`` has every byte (topic ``/camera/raw``), ``camera.toml`` is the camera's file.

    Raises
    ------
    DriverError, CannotWrite
        What address, port or disk refuse.
    """
    replace_file(folder / CAMERA_FILE, described.content)
    with RestartingReader(described.address.text, folder, CAMERA_SESSION) as reader:
        yield CameraFeed(reader, clock)


def recorded_images(folder: Path) -> Iterator[CameraImage]:
    """Yield the images of all sessions in a folder; raises as `recorded_readings`."""
    return recorded_readings(folder, CAMERA_SESSION, CAMERA_RAW_TOPIC, lambda: CameraDecoder().feed)


def recorded_tracks(folder: Path, marks: Iterable[tuple[int, float]]) -> CameraTracks | None:
    """Return what the camera with a recording saw; None where there was none.

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
        times.stamp_imu(host_ns, device_s)
    for image in recorded_images(folder):  # all of them, so that one line holds for all of a clock
        if image.device_ns is not None:
            times.stamp_sender(TimeMark(image.host_ns, image.device_ns, None))
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

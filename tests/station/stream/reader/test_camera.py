"""The reader process on a camera's stream: its images, a hang-up, and every byte in the recording."""

import time
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from drivers.camera import CameraDecoder, CameraImage
from drivers.errors import PortNotFound
from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.reader.reader import RestartingReader
from tests.patience import HANG_S
from tests.refusals import refused

pytest.importorskip("cv2", reason="opencv is not installed")
Got = tuple[list[Chunk], list[StreamGap], list[CameraImage]]


def collect(reader: Reader | RestartingReader, images: int, marks: int = 0) -> Got:
    """Read until there are so many images and gap marks."""
    decoder, deadline = CameraDecoder(), time.monotonic() + HANG_S
    got: Got = [], [], []
    while len(got[2]) < images or len(got[1]) < marks:
        assert time.monotonic() < deadline, decoder.counters
        for item in reader.poll(1.0):
            if isinstance(item, StreamGap):
                got[1].append(item)
            else:
                got[0].append(item)
                got[2].extend(decoder.feed(item.data, item.host_ns))
    return got


def recorded(folder: Path) -> bytes:
    """Return all bytes in the recordings of a folder."""
    found = b""
    for path in sorted(folder.glob("*.mcap")):
        with path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            found += b"".join(message.data for *_, message in reader.iter_decoded_messages([CAMERA_RAW_TOPIC]))
    return found


def test_images_come_through_a_hang_up_and_every_byte_is_in_the_recording(tmp_path: Path) -> None:
    with (
        SimulatedCamera(Truth(), seed=None) as camera,
        RestartingReader(camera.url, tmp_path, "camera_session") as reader,
    ):
        chunks, marks, images = collect(reader, 5)
        assert not marks
        camera.plant("unplug", seconds=0.3)
        more = collect(reader, 5, marks=2)
    assert [mark.is_open for mark in more[1]] == [False, True]
    assert "back after" in more[1][1].reason
    for image in [*images, *more[2]]:
        assert image.device_ns is not None
        assert image.jpeg.startswith(b"\xff\xd8")
        assert abs(image.host_ns - time.time_ns()) < 3600e9  # counted from the epoch
    stamps = [image.device_ns or 0 for image in [*images, *more[2]]]
    assert stamps == sorted(set(stamps))
    sent = b"".join(chunk.data for chunk in [*chunks, *more[0]])
    assert recorded(tmp_path).startswith(sent)
    assert [path.name[:15] for path in tmp_path.iterdir()] == ["camera_session_"]
    assert camera.failure is None


def test_a_reader_that_hears_nothing_says_until_when(tmp_path: Path) -> None:
    """Whoever merges images with another stream goes on by it."""
    with SimulatedCamera(Truth()) as camera, Reader(camera.url, tmp_path / "camera_session.mcap") as reader:
        collect(reader, 1)
        camera.plant("stall", seconds=1000.0)
        while reader.poll(0.2):
            pass
        before, deadline = reader.up_to_ns, time.monotonic() + HANG_S
        while reader.up_to_ns == before and time.monotonic() < deadline:
            if reader.poll(0.1):  # an image that was on its way
                before = reader.up_to_ns
        assert reader.up_to_ns > before


def test_a_password_is_not_written_down(tmp_path: Path) -> None:
    with SimulatedCamera(Truth()) as camera:
        url = camera.url.replace("http://", "http://me:secret@")
        with Reader(url, tmp_path / "camera_session.mcap") as reader:
            collect(reader, 1)
    assert b"secret" not in (tmp_path / "camera_session.mcap").read_bytes()


def test_what_is_no_camera_is_reported_as_it_is(tmp_path: Path) -> None:
    with SimulatedCamera(Truth()) as camera, refused(PortNotFound, ErrorCode.DEVICE, "404"):
        Reader(camera.url + "s", tmp_path / "camera_session.mcap").start()

"""The raw recording: everything in order, on the disk before its end, and a disk that refuses is told once."""

import errno
import os
from contextlib import suppress
from pathlib import Path
from threading import Event

import pytest
from mcap.reader import make_reader

from procedures.errors import ErrorCode
from station.errors import CannotWrite, DiskFull
from station.files.mcap_files import read_step
from station.files.mcap_files.schemas import MESSAGES, RAW, RAW_TOPIC
from station.stream.reader import Chunk, StreamGap
from station.stream.reader import raw_recording as recording_module
from station.stream.reader.raw_recording import RawRecording
from tests.patience import HANG_S
from tests.refusals import refused

HOST = 1_780_000_000 * 10**9


def fail(error: CannotWrite) -> None:
    pytest.fail(str(error))


def test_bytes_gaps_and_the_sessions_begin_stand_in_it_in_order(tmp_path: Path) -> None:
    recording = RawRecording(tmp_path / "a.mcap", {"url": "here", "program": "station"}, fail, "/a/topic")
    for i in range(50):
        recording.put(Chunk(HOST + i, bytes([i, 0, 255])))
    recording.put(StreamGap(HOST + 50, "port lost: gone", False))
    recording.put(StreamGap(HOST + 60, "port back after 1 s", True))
    recording.put(Chunk(HOST + 70, b""))
    recording.close()
    with recording.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert [(each.name, each.metadata) for each in reader.iter_metadata()] == [
            ("station.session", {"url": "here", "program": "station"}),
            ("station.gap", {"host_ns": str(HOST + 50), "reason": "port lost: gone", "is_open": "false"}),
            ("station.gap", {"host_ns": str(HOST + 60), "reason": "port back after 1 s", "is_open": "true"}),
        ]
        found = list(reader.iter_messages(log_time_order=False))
    assert {channel.topic for _, channel, _ in found} == {"/a/topic"}
    assert {schema.name for schema, _, _ in found if schema is not None} == {RAW}
    contents = [MESSAGES[RAW].FromString(message.data) for _, _, message in found]
    assert [(each.host_ns, each.data) for each in contents] == [
        *((HOST + i, bytes([i, 0, 255])) for i in range(50)), (HOST + 70, b""),
    ]  # fmt: skip
    assert all(message.log_time == message.publish_time for _, _, message in found)
    assert [message.log_time for _, _, message in found] == [each.host_ns for each in contents]


def test_what_came_is_on_the_disk_while_the_session_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording_module, "FLUSH_S", 0.01)
    monkeypatch.setattr(recording_module, "SYNC_S", 0.02)
    path, there, real = tmp_path / "a.mcap", Event(), os.fsync

    def fsync(descriptor: int) -> None:
        real(descriptor)
        if path.is_file() and [data for _, data in read_step(path).raw] == [b"abc"]:
            there.set()

    monkeypatch.setattr(os, "fsync", fsync)
    recording = RawRecording(path, {}, fail, RAW_TOPIC)
    assert not there.is_set()
    recording.put(Chunk(HOST, b"abc"))
    assert there.wait(HANG_S)
    recording.close()
    assert read_step(path).damage is None


def test_at_its_end_the_data_are_on_the_disk_before_the_end_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = RawRecording(tmp_path / "a.mcap", {}, fail, RAW_TOPIC)
    found, real = list[tuple[int, bool]](), os.fsync

    def fsync(descriptor: int) -> None:
        real(descriptor)
        read = read_step(recording.path)
        found.append((len(read.raw), read.damage is None))

    monkeypatch.setattr(os, "fsync", fsync)
    recording.put(Chunk(HOST, b"abc"))
    recording.close()
    assert found[-2:] == [(1, False), (1, True)]


def test_the_beginning_is_on_the_disk_before_anything_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, synced, real = tmp_path / "a.mcap", list[tuple[int, bool]](), os.fsync

    def fsync(descriptor: int) -> None:
        real(descriptor)
        is_file = os.fstat(descriptor).st_ino == path.stat().st_ino
        synced.append((path.stat().st_size, is_file))

    monkeypatch.setattr(os, "fsync", fsync)
    recording = RawRecording(path, {"url": "here"}, fail, RAW_TOPIC)
    begun = list(synced)
    recording.close()
    assert [is_file for _, is_file in begun] == [True, False]  # the file, then its name
    assert begun[0][0] > 0


def is_open(path: Path) -> bool:
    """Say whether this process has a file open; a descriptor may go away as they are listed."""
    found = list[str]()
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):
            found.append(os.readlink(f"/proc/self/fd/{name}"))
    return str(path) in found


def test_a_disk_that_refuses_is_reported_once_with_the_files_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures = list[CannotWrite]()
    recording = RawRecording(tmp_path / "a.mcap", {}, failures.append, RAW_TOPIC)

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    for i in range(10):
        recording.put(Chunk(HOST + i, b"abc"))
    recording.close()
    (failure,) = failures
    assert isinstance(failure, DiskFull)
    assert failure.path == str(recording.path)
    assert not is_open(recording.path)


def test_a_disk_that_refuses_the_beginning_refuses_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with refused(DiskFull, ErrorCode.DISK_FULL, "a.mcap") as refusal:
        RawRecording(tmp_path / "a.mcap", {}, fail, RAW_TOPIC)
    assert not is_open(tmp_path / "a.mcap")
    del refusal  # until here its traceback holds the recording


def test_a_recording_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"of another session")
    with pytest.raises(CannotWrite):
        RawRecording(tmp_path / "a.mcap", {}, fail, RAW_TOPIC)
    assert (tmp_path / "a.mcap").read_bytes() == b"of another session"

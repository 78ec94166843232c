"""The queue to the station: it never waits, and says what it could not keep."""

import os

import pytest

from drivers.device_url_parser import parse_device_url
from station.stream.reader import __main__ as process
from station.stream.reader.messages import Chunk, GapMark, unpacked
from station.stream.reader.send_queue import Outbox
from tests.patience import HANG_S


def test_a_station_that_does_not_read_makes_nobody_wait() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=1_000_000)
    taken = 0
    while outbox.put(b"x" * 1000):  # many times what a pipe holds
        taken += 1
    assert 900 < taken < 1200
    assert outbox.put(b"y", always=True)
    got = 0
    while got < taken * 1000 + 1:
        got += len(os.read(reading, 65536))
    outbox.wait_for_room(60.0)
    assert outbox.put(b"z")
    outbox.close(60.0)
    assert os.read(reading, 10) == b"z"


def test_messages_arrive_whole_and_in_order_however_large(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    sizes, real = list[int](), os.write

    def write(descriptor: int, data: memoryview) -> int:
        if descriptor != writing:
            return real(descriptor, data)
        sizes.append(len(data))
        return real(descriptor, data[: max(1, len(data) // 2)])  # as a pipe that is nearly full

    monkeypatch.setattr(os, "write", write)
    outbox = Outbox(writing)
    said = [bytes([i]) * size for i, size in enumerate((1, 0, 200_000, 3, 70_000))]
    for message in said:
        assert outbox.put(message)
    got = b""
    while len(got) < sum(map(len, said)):
        got += os.read(reading, 65536)
    outbox.close(HANG_S)
    assert got == b"".join(said)
    assert max(sizes) <= 65536


def test_room_ends_one_message_beyond_the_limit_and_what_goes_always_counts() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=200_000)
    assert outbox.put(b"x" * 150_000, always=True)
    assert outbox.put(b"x" * 150_000)  # what waits is within the limit, less what the pipe has taken
    assert not outbox.put(b"y")
    assert outbox.put(b"z" * 150_000, always=True)
    got = 0
    while got < 100_000:
        got += len(os.read(reading, 50_000))
    assert not outbox.put(b"y")
    while got < 450_000:
        got += len(os.read(reading, 65536))
    outbox.wait_for_room(HANG_S)
    assert outbox.put(b"y")
    outbox.close(HANG_S)
    assert os.read(reading, 10) == b"y"


class Crowded:
    """An outbox that has room, or has none, as it was told; what it takes is kept."""

    def __init__(self, *has_room: bool) -> None:
        self.has_room, self.taken = list(has_room), bytearray()

    def put(self, message: bytes, *, always: bool = False) -> bool:
        has_room = self.has_room.pop(0)
        self.taken += message if has_room else b""
        return has_room


def test_each_byte_that_was_not_collected_is_told_of_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "open_port", lambda url: None)
    outbox = Crowded(False, False, True, False, True, True, True)
    url = parse_device_url("serial:///dev/ttyUSB0?format=counts")
    session = process._Session(url, None, outbox)  # noqa: SLF001
    for host_ns, size in enumerate((3, 5, 7, 11, 13)):
        session._hand_on(Chunk(host_ns, b"x" * size))  # noqa: SLF001
    assert outbox.has_room == []
    assert list(unpacked(outbox.taken)) == [
        GapMark(2, "8 bytes not collected in time; they are lost", is_open=True),
        GapMark(3, "7 bytes not collected in time; they are lost", is_open=True),
        Chunk(3, b"x" * 11),
        Chunk(4, b"x" * 13),
    ]

"""The queue to the station: never waits, and says what it could not keep."""

import os

import pytest

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


def test_a_message_beyond_the_limit_waits_and_room_is_half_of_it() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=100_000)
    assert outbox.put(b"x" * 300_000)  # one: what waits was within the limit
    assert not outbox.put(b"y")
    outbox.wait_for_room(0.01)  # nobody reads: it gives up
    assert not outbox.put(b"y")
    got = 0
    while got < 300_000:
        got += len(os.read(reading, 65536))
    outbox.wait_for_room(HANG_S)
    assert outbox.put(b"z")
    outbox.close(60.0)
    assert os.read(reading, 10) == b"z"


def test_who_waits_for_room_goes_on_when_the_station_is_gone() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=100_000)
    assert outbox.put(b"x" * 300_000)
    os.close(reading)
    outbox.wait_for_room(HANG_S)
    assert outbox.put(b"y")  # lost with the rest, but nobody waits
    outbox.close(60.0)


def test_a_station_that_is_gone_ends_it_quietly() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    outbox = Outbox(writing)
    outbox.put(b"x")
    outbox.close(60.0)
    assert not outbox._thread.is_alive()  # noqa: SLF001


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


def test_what_was_queued_is_sent_before_it_closes() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing)
    for i in range(100):
        outbox.put(bytes([i]))
    outbox.close(HANG_S)
    assert os.read(reading, 1000) == bytes(range(100))
    os.close(writing)
    assert os.read(reading, 1000) == b""


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


def test_without_any_room_one_message_waits_at_a_time() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=0)
    assert outbox.put(b"x" * 300_000)
    assert not outbox.put(b"y")
    os.close(reading)
    outbox.wait_for_room(HANG_S)  # there will be none, and nobody to wait for
    outbox.close(HANG_S)

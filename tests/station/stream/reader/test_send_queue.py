"""The queue to the station: never waits, and says what it could not keep."""

import os

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

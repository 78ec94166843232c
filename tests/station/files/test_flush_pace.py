"""On a disk that takes long for a flush the time is not spent on flushing alone."""

import time

import pytest

from station.files.flush_pace import FlushPace


def test_what_takes_long_is_done_no_more_than_half_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    pace, flushes = FlushPace(0.2), 0
    for _ in range(12_000):  # a piece of 10 ms each
        now[0] += 0.01
        if pace.is_due:
            flushes += 1
            with pace.flushing():
                now[0] += 10.0
    assert flushes * 10.0 <= now[0] / 2 + 10.0
    assert flushes >= 10

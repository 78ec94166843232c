"""UTC by marks of a receiver whose clock runs 50 ppm faster than the station's."""

import numpy as np
import pytest

from station.stream.gnss.utc_line import UtcLine

HOST, UTC = 5_000 * 10**9, 1_780_000_000 * 10**9
RATE = 1 + 50e-6


def marked(seconds: float, begin: float = 0.0, step_s: float = 0.0) -> UtcLine:
    """Return a line with ten marks a second, each read up to 2 ms late; ``step_s`` is added after 60 s."""
    line, rng = UtcLine(), np.random.default_rng(1)
    for t in np.arange(begin, begin + seconds, 0.1).tolist():
        later = step_s if t >= 60.0 else 0.0
        line.mark(HOST + round((t + rng.uniform(0.0, 0.002)) * 1e9), UTC + round((t * RATE + later) * 1e9))
    return line


@pytest.mark.parametrize("t", [5.0, 61.5, 110.0])
def test_utc_is_read_off_the_marks_around_a_moment(t: float) -> None:
    utc = marked(120.0).utc(HOST + round(t * 1e9))
    assert utc == pytest.approx(UTC / 1e9 + t * RATE, abs=0.001)


def test_a_moment_an_hour_on_is_not_told_by_marks_of_the_first_minutes() -> None:
    line = marked(60.0)
    assert line.utc(HOST + 3600 * 10**9) is None
    assert line.utc(HOST) is not None


def test_marks_of_another_time_do_not_shift_it() -> None:
    line = marked(180.0, step_s=7.0)
    assert line.utc(HOST + 20 * 10**9) == pytest.approx(UTC / 1e9 + 20 * RATE, abs=0.001)
    assert line.utc(HOST + 160 * 10**9) == pytest.approx(UTC / 1e9 + 160 * RATE + 7.0, abs=0.001)


def test_without_marks_nothing_is_told_and_their_scatter_is_that_of_the_reading() -> None:
    line = UtcLine()
    assert (line.utc(HOST), line.scatter) == (None, 0.0)
    line = marked(60.0)
    line.utc(HOST + 30 * 10**9)
    assert 2e-4 < line.scatter < 2e-3  # uniform over 2 ms: 0.58 ms
    line.begin_anew()
    assert line.utc(HOST + 45 * 10**9) is None

"""The live watch of the sample rate on recorded delays of a busy machine: load alone ends and warns of nothing."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from station.errors import DataRefused
from station.stream.gnss.sample_rate import SampleRate
from station.stream.gnss.utc_line import UtcLine
from tests.procedures.counts.recorded_delays import read_traces, timeline

TRACES = read_traces()
SECONDS = 80.0


def watched(loads: tuple[int, ...], off: float, seed: int) -> SampleRate:
    """Return a watch that looked at a device whose samples last ``off`` (relative) longer than it says."""
    line = timeline([t for t in TRACES if t.load in loads], SECONDS, np.random.default_rng([7, seed]))
    stream = SimpleNamespace(counters=SimpleNamespace(restarts=0, clock_jumps=0))
    imu = SimpleNamespace(name="imu")
    feed = SimpleNamespace(stamp=None, pulse_age=None, period=0.02, address=imu, stream=stream)
    utc, marks = UtcLine(), zip(line.mark_ns.tolist(), line.mark_s.tolist(), strict=True)
    rate = SampleRate(feed, utc.utc, lambda: utc.scatter)  # type: ignore[arg-type]
    looks = itertools.count(0.0, 0.06)
    rate.clock = lambda: float(next(looks))
    mark = next(marks)
    for true, host in zip(line.row_s.tolist(), line.row_ns.tolist(), strict=True):
        while mark[0] <= host and (following := next(marks, None)) is not None:
            utc.mark(mark[0], round(mark[1] * 1e9))
            mark = following
        feed.stamp = host, true / (1 + off)
        rate.look()
    return rate


@pytest.mark.parametrize("loads", [(0, 1), (2, 4), (8, 15), (15,)])
@pytest.mark.parametrize("seed", range(2))
def test_load_alone_neither_warns_of_the_rate_nor_ends_a_campaign(loads: tuple[int, ...], seed: int) -> None:
    assert watched(loads, 0.0, seed).warning == ""


@pytest.mark.parametrize("loads", [(0, 1), (2, 4)])
def test_a_device_that_is_off_is_refused_under_load_too(loads: tuple[int, ...]) -> None:
    with pytest.raises(DataRefused, match=r"1\.[45]\d% off"):
        watched(loads, 0.015, 1)

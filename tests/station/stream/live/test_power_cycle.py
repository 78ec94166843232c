"""Whether a device was switched off and on: by its clock, through every wire format that has one."""

import pytest

from drivers.simulated.line_faults import Fault
from drivers.simulated.truth import Truth
from station.stream.live.live_feed import open_feed
from station.stream.live.power_cycle import switched_on_again, switched_on_again_within
from tests.station.stream.live.bench_in_memory import Source


@pytest.mark.parametrize(
    ("before", "now", "elapsed", "expected"),
    [
        (1000.0, 3.0, 10.0, True),  # began again
        (1000.0, 1030.0, 30.0, False),  # the port alone was away
        (1000.0, 1000.5, 600.0, False),  # a simulated device that nobody read
        (1000.0, 7200.0, 86400.0, True),  # switched on two hours ago, the next day
        (1000.0, 1600.0, 10.0, False),  # a simulated device that runs faster
    ],
)
def test_a_clock_that_does_not_turn(before: float, now: float, elapsed: float, *, expected: bool) -> None:
    assert switched_on_again(before, now, elapsed) is expected


@pytest.mark.parametrize(
    ("before", "now", "elapsed", "turn", "expected"),
    [
        (4290.0, 5.0, 10.0, 4294.967, False),  # it turned
        (2000.0, 3.0, 10.0, 4294.967, True),
        (2000.0, 2010.0, 10.0, 4294.967, False),
        (0.5, 0.1, 10.0, 1.0, False),  # it turns too soon to tell
        (2000.0, 3000.0, 10.0, 4294.967, False),  # strange, and no beginning
    ],
)
def test_a_clock_that_turns(before: float, now: float, elapsed: float, turn: float, *, expected: bool) -> None:
    assert switched_on_again_within(before, now, elapsed, turn) is expected


@pytest.mark.parametrize("format", ["counts", "rawimux", "stim300"])  # the last one's clock turns too soon to tell
@pytest.mark.parametrize(
    ("kind", "restarts"),
    [("restart", 1), ("unplug", 0), ("stall", 0), ("lost", 0), ("counter_restart", 0), ("clock_jump", 0)],
)
def test_a_restart_is_told_from_all_else_that_interrupts_a_stream(format: str, kind: str, restarts: int) -> None:
    truth = Truth.example(1)
    feed = open_feed(Source(truth, [Fault(kind, at_s=30.0, seconds=8.0, count=20)], format))
    if format == "counts":
        feed.identify()
    else:
        feed.identify("FOG", "1")
    blocks = feed.blocks()
    while next(blocks).first < 50 / truth.sample_period_s - 600:
        feed.buffer.forget_before(feed.buffer.end)
    assert feed.restarts == (restarts if format != "stim300" else 0)

"""Two devices on one line whose samples cannot be told apart one by one: no second of them is used."""

import numpy as np
import pytest

from drivers.simulated.line_faults import Fault
from procedures.arrays import IntArray
from station.stream.live.live_feed import LiveFeed
from tests.station.stream.live.line_in_memory import PERIOD, LineInMemory, Memory

SECONDS = 60.0


def twins(seed: int) -> list[Fault]:
    """Return short and long presences of another device, its counter the same or a few ahead.

    Each begins with the last sample of a second that would otherwise be whole: where it is hardest to see in time.
    """
    rng, faults, at = np.random.default_rng(seed), list[Fault](), 201
    while at * PERIOD < SECONDS:
        lasts, ahead = int(rng.choice((1, 1, 1, 3, 25))), int(rng.choice((0, 0, 1, 2, 8)))
        faults.append(Fault("two_devices", at * PERIOD, seconds=lasts * PERIOD, count=ahead))
        at += lasts - 1 + round(int(rng.integers(1, 3)) / PERIOD)
    return faults


def whole_seconds(format: str, seed: int) -> list[IntArray]:
    """Return of which samples of one device the whole seconds are, below 0 for those of the other."""
    line, memory = LineInMemory(format, twins(seed)), Memory(round((SECONDS + 1) / PERIOD))
    feed = LiveFeed(line, line.wire, clock=line.clock)
    feed.identify("SIM", None if format == "counts" else "7")
    blocks = []
    while line.clock() < SECONDS:
        feed.advance()
        blocks += [memory.which(feed.buffer.block(each.first, each.last)) for each in feed.ready()]
    return blocks


@pytest.mark.parametrize("format", ["counts", "rawimusx", "stim300", "can"])
def test_no_sample_of_a_twin_is_in_a_second_whoever_speaks_first(format: str) -> None:
    blocks = whole_seconds(format, 1)
    wrong = [block for block in blocks if (block < 0).any() or (np.diff(block) != 1).any()]
    assert not wrong
    assert len(blocks) > 0.1 * SECONDS

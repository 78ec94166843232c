"""Every fault of a line in the station's own time: told within 2 s, over 3 s after its end."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.errors import DriverError
from drivers.simulated.faults import Fault
from procedures.arrays import IntArray
from station.stream.live.live_feed import LiveFeed
from tests.station.stream.live.line_in_memory import PERIOD, LineInMemory, Memory
from tests.station.stream.reader.faulty import CASES, SLOT_S, Case, begins_s, has_reported

REPORTED_S, BACK_S = 2.0, 3.0
LOOKS_S = 0.1  # apart
KEPT = 500  # samples


class Run:
    """What was said when, and when samples and whole seconds came [s of the station's clock]."""

    def __init__(self, format: str) -> None:
        line = LineInMemory(format, [replace(case.fault, at_s=begins_s(case)) for case in CASES])
        feed = LiveFeed(line, line.wire, clock=line.clock)
        self.reported: list[tuple[float, str]] = []
        self.samples_at: list[float] = []
        self.seconds_at: list[float] = []
        while line.clock() < begins_s(CASES[-1]) + SLOT_S:
            before, text = feed.buffer.end, ""
            try:
                feed.advance()
                text = f"was lost ({feed.lost})" if feed.lost else ""
            except DriverError as error:
                text = str(error)
            self.reported += [(line.clock(), each) for each in (text, feed.trouble) if each]
            self.samples_at += [line.clock()] if feed.buffer.end > before else []
            if feed.unit is None and feed.buffer.end > 100:
                feed.identify("SIM", None if feed.stream.decoder.serial else "7")
            self.seconds_at += [line.clock() for _ in (feed.ready() if feed.unit else ())]
            if feed.buffer.end > feed.buffer.first + 2 * KEPT:
                feed.buffer.forget_before(feed.buffer.end - KEPT)


@pytest.fixture(scope="module")
def runs() -> dict[str, Run]:
    return {format: Run(format) for format in ("counts", "can")}


@pytest.mark.parametrize("format", ["counts", "can"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "_"))
def test_every_fault_is_reported_within_two_seconds_and_over_within_three(
    case: Case, format: str, runs: dict[str, Run]
) -> None:
    run, begins = runs[format], begins_s(case)
    over = begins + case.lasts_s
    reported = [(at - begins, text) for at, text in run.reported if begins <= at < begins + SLOT_S - LOOKS_S]
    expected = case.reported_on("pty" if format == "counts" or case.fault.kind == "unplug" else "udp_multicast")
    reported_at = [at for at, text in reported if has_reported([text], expected)] if expected else []
    assert bool(reported_at) == bool(expected), reported
    assert all(at <= REPORTED_S for at in reported_at[:1])
    assert next(at for at in run.samples_at if at >= over + LOOKS_S) <= over + BACK_S
    assert next(at for at in run.seconds_at if at >= over + 1) <= over + BACK_S, "a whole second was used again"
    assert [text for at, text in reported if at > case.lasts_s + BACK_S] == [], "it is over"


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

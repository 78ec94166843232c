"""Every fault of a line in the station's own time: told within 2 s of its beginning, over 3 s after its end."""

from dataclasses import replace

import pytest

from drivers.errors import DriverError
from station.stream.live.live_feed import LiveFeed
from tests.station.stream.live.line_in_memory import LineInMemory
from tests.station.stream.reader.faulty import CASES, SLOT_S, Case, begins_s, has_said

TOLD_S, BACK_S = 2.0, 3.0
LOOKS_S = 0.1  # apart
KEPT = 500  # samples


class Run:
    """What was said when, and when samples and whole seconds came [s of the station's clock]."""

    def __init__(self, format: str) -> None:
        line = LineInMemory(format, [replace(case.fault, at_s=begins_s(case)) for case in CASES])
        feed = LiveFeed(line, line.wire, clock=line.clock)
        self.said: list[tuple[float, str]] = []
        self.samples_at: list[float] = []
        self.seconds_at: list[float] = []
        while line.clock() < begins_s(CASES[-1]) + SLOT_S:
            before, text = feed.buffer.end, ""
            try:
                feed.advance()
                text = f"was lost ({feed.lost})" if feed.lost else ""
            except DriverError as error:
                text = str(error)
            self.said += [(line.clock(), each) for each in (text, feed.trouble) if each]
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
def test_every_fault_is_told_within_two_seconds_and_over_within_three(
    case: Case, format: str, runs: dict[str, Run]
) -> None:
    run, begins = runs[format], begins_s(case)
    over = begins + case.lasts_s
    said = [(at - begins, text) for at, text in run.said if begins <= at < begins + SLOT_S - LOOKS_S]
    expected = case.said_on("pty" if format == "counts" or case.fault.kind == "unplug" else "udp_multicast")
    told = [at for at, text in said if has_said([text], expected)] if expected else []
    assert bool(told) == bool(expected), said
    assert all(at <= TOLD_S for at in told[:1])
    assert next(at for at in run.samples_at if at >= over + LOOKS_S) <= over + BACK_S
    assert next(at for at in run.seconds_at if at >= over + 1) <= over + BACK_S, "a whole second was used again"
    assert [text for at, text in said if at > case.lasts_s + BACK_S] == [], "it is over"

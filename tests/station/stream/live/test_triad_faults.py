"""Faults of one gyro of three: told within 2 s, over within 3 s, and no second holds a foreign share."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from drivers.errors import DriverError
from drivers.simulated.faults import Fault
from procedures.arrays import IntArray
from station.stream.live.live_feed import LiveFeed
from tests.station.stream.live.triad_in_memory import PERIOD, TriadInMemory, which

BEGIN_S, SLOT_S, LASTS_S = 8.0, 9.0, 3.0
REPORTED_S, BACK_S = 2.0, 3.0
KEPT = 600  # samples
AXES = (0, 2)  # x leads the others
FRAMELESS = "hold no triad frame"
BREAK = "samples lost|breaks|new beginning"


@dataclass(frozen=True)
class Case:
    """A fault of one gyro, how long it lasts [s] and what the operator must read."""

    name: str
    fault: Fault
    says: str
    lasts_s: float = LASTS_S


CASES = (
    Case("babbling", Fault("noise", 0.0, seconds=LASTS_S), FRAMELESS),
    Case("wrong baud", Fault("wrong_baud", 0.0, seconds=LASTS_S), FRAMELESS),
    Case("silent", Fault("stall", 0.0, seconds=LASTS_S), FRAMELESS),
    Case("half frames", Fault("half", 0.0, count=5), BREAK, 0.1),
    Case("lost", Fault("lost", 0.0, count=3), BREAK, 0.1),
    Case("duplicates", Fault("repeated", 0.0, count=3), BREAK, 0.1),
    Case("backlog", Fault("backlog", 0.0, seconds=LASTS_S), FRAMELESS),
    Case("two devices", Fault("two_devices", 0.0, seconds=LASTS_S), BREAK),
    Case("restart", Fault("restart", 0.0, seconds=1.0), BREAK, 1.0),
)


def begins_s(case: Case) -> float:
    return BEGIN_S + SLOT_S * CASES.index(case)


class Run:
    """What a station saw of a triad of which one gyro has all the faults, one after another."""

    def __init__(self, axis: int) -> None:
        faults = [replace(case.fault, at_s=begins_s(case)) for case in CASES]
        triad = TriadInMemory(axis, faults, seed=axis + 1)
        feed = LiveFeed(triad, triad.wire, clock=triad.clock)
        self.reported: list[tuple[float, str]] = []
        self.blocks: list[IntArray] = []
        while triad.clock() < begins_s(CASES[-1]) + SLOT_S:
            try:
                feed.advance()
            except DriverError as error:
                self.reported.append((triad.clock(), str(error)))
            if feed.trouble:
                self.reported.append((triad.clock(), feed.trouble))
            if feed.unit is None and feed.stream.period is not None:
                feed.identify("CH-70", "7")
            for each in feed.ready() if feed.unit else ():
                self.blocks.append(which(feed.buffer.block(each.first, each.last)))
            if feed.buffer.end > feed.buffer.first + 2 * KEPT:
                feed.buffer.forget_before(feed.buffer.end - KEPT)


@pytest.fixture(scope="module")
def runs() -> dict[int, Run]:
    return {axis: Run(axis) for axis in AXES}


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "_"))
def test_a_fault_of_one_gyro_of_three_is_reported_and_over(case: Case, axis: int, runs: dict[int, Run]) -> None:
    begins, run = begins_s(case), runs[axis]
    reported = [(at - begins, text) for at, text in run.reported if begins <= at < begins + SLOT_S]
    noticed = [at for at, text in reported if any(words in text for words in case.says.split("|"))]
    assert noticed, reported
    assert noticed[0] <= REPORTED_S
    over = round((begins + case.lasts_s) / PERIOD)
    begun = [int(block[0, 0]) for block in run.blocks if block[0, 0] >= over]
    assert begun[0] <= over + BACK_S / PERIOD


@pytest.mark.parametrize("axis", AXES)
def test_no_second_of_a_triad_holds_a_share_that_is_not_its_own(axis: int, runs: dict[int, Run]) -> None:
    blocks = runs[axis].blocks
    assert len(blocks) > 25
    for shares in blocks:
        assert (shares >= 0).all()
        assert (np.diff(shares, axis=0) == 1).all()
        assert (shares == shares[:, :1]).all()

"""Every fault on every transport, read by the real reader: it is told, marked and over, and no wrong sample is used."""

from collections.abc import Iterator

import numpy as np
import pytest

from tests.station.reader.faulty import CASES, PERIOD, SLOT_S, TRANSPORTS, Case, Run, begins_s, has_said, run_all

BACK_S = 3.0


@pytest.fixture(scope="module")
def runs() -> Iterator[dict[str, Run]]:
    yield run_all()


@pytest.mark.parametrize("transport", TRANSPORTS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "_"))
def test_every_fault_is_told_marked_and_over(case: Case, transport: str, runs: dict[str, Run]) -> None:
    run = runs[transport]
    texts, expected = run.texts(case), case.said_on(transport)
    assert has_said(texts, expected) if expected else not texts, texts
    first = round(begins_s(case) / PERIOD)
    over = first + round(case.lasts_s / PERIOD)
    here = run.index[(run.index >= first) & (run.index < first + round((SLOT_S - 1) / PERIOD))]
    assert here[here >= over][0] <= over + BACK_S / PERIOD, "samples come again"
    begun = [int(block[0]) for block in run.blocks if block[0] >= over]
    assert begun[0] <= over + BACK_S / PERIOD, "a second is whole again"
    assert run.is_alive


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_what_is_missing_is_marked_and_nothing_else_is(transport: str, runs: dict[str, Run]) -> None:
    run = runs[transport]
    steps = np.diff(run.index)
    gaps = set((np.flatnonzero(steps != 1) + 1).tolist())
    assert gaps <= set(run.feed.marked)
    for case in CASES:
        gone = case.gone.get(transport, case.gone.get("*", -1))
        if gone >= 0:
            first = round(begins_s(case) / PERIOD)
            last = first + round((SLOT_S - 1) / PERIOD)
            there = np.unique(run.index[(run.index >= first) & (run.index < last)])
            assert last - first - len(there) == pytest.approx(gone, abs=2), case.name


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_no_second_that_a_dwell_may_use_holds_a_wrong_or_a_missing_sample(
    transport: str, runs: dict[str, Run]
) -> None:
    run = runs[transport]
    assert len(run.blocks) > 50
    for block in run.blocks:
        assert (block >= 0).all()
        assert (np.diff(block) == 1).all()

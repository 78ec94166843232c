"""Every fault on every transport, by the real reader: told, marked, over, and no wrong sample is used."""

import numpy as np
import pytest

from station.stream.live.live_feed import MIN_HELD_SAMPLES
from tests.patience import paced
from tests.station.stream.reader.faulty import (
    CASES,
    DEAF,
    PERIOD,
    SILENT,
    SLOT_S,
    SPEED,
    TRANSPORTS,
    Case,
    Run,
    back_s,
    begins_s,
    has_reported,
    run_all,
)


@pytest.fixture(scope="module")
def runs() -> dict[str, Run]:
    return run_all(paced(SPEED))


@pytest.mark.parametrize("transport", TRANSPORTS)
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "_"))
def test_every_fault_is_reported_marked_and_over(case: Case, transport: str, runs: dict[str, Run]) -> None:
    run = runs[transport]
    texts, expected = run.texts(case), case.reported_on(transport)
    if not expected:
        # 0.2 s of a busy machine are 2 s of silence here, 1 s of it an adapter that does not answer: it is said
        texts = [text for text in texts if SILENT not in text and DEAF not in text]
    assert has_reported(texts, expected) if expected else not texts, texts
    first = round(begins_s(case) / PERIOD)
    over = first + round(case.lasts_s / PERIOD)
    here = run.index[run.index >= first]
    assert here[here >= over][0] <= over + back_s(case) / PERIOD, "samples come again"
    begun = [int(block[0]) for block in run.blocks if block[0] >= over]
    # a busy machine that stops for 0.2 s is one more silence of 2 s here: the next slot then has the first
    assert begun[0] <= over + (back_s(case) + SLOT_S) / PERIOD, "a second is whole again"
    assert run.is_alive


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_what_is_missing_is_marked_and_nothing_else_is(transport: str, runs: dict[str, Run]) -> None:
    run = runs[transport]
    ours, marked = np.flatnonzero(run.index >= 0), set(run.feed.marked)
    gaps = set(ours[1:][np.diff(run.index[ours]) != 1].tolist())
    assert gaps <= marked
    for other in np.flatnonzero(run.index < 0).tolist():  # it may be told by what came after it only
        assert marked & set(range(other, other + MIN_HELD_SAMPLES + 1))
    for case in CASES:
        gone = case.gone.get(transport, case.gone.get("*", -1))
        if gone >= 0:
            first = round(begins_s(case) / PERIOD)
            last = first + round((SLOT_S - 1) / PERIOD)
            there = np.unique(run.index[(run.index >= first) & (run.index < last)])
            assert gone - 2 <= last - first - len(there) <= gone + 2, case.name


@pytest.mark.parametrize("transport", TRANSPORTS)
def test_no_second_that_a_dwell_may_use_holds_a_wrong_or_a_missing_sample(
    transport: str, runs: dict[str, Run]
) -> None:
    run = runs[transport]
    assert len(run.blocks) > 50
    for block in run.blocks:
        assert (block >= 0).all()
        assert (np.diff(block) == 1).all()

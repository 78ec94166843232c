"""Moves between accepted steps: every row in between, and none where anything breaks them."""

from collections.abc import Callable

import numpy as np
import pytest

from procedures.campaign.plan_steps import Dwell, Monitor, Turn
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.guide.move_chain import ANEW, INTERRUPTED, LONG, LOST, MoveChain
from station.stream.recorder.accepted_step_writer import MovedFrom
from tests.station.guide.recorded import SAMPLES, TAPE
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def carried(guided: GuideRig) -> list[tuple[str, str]]:
    """Return what the folder's moves lead from and to; that reads and agrees with its hashes."""
    verify_folder(guided.folder)
    moves = read_campaign(guided.folder).campaign.moves
    return [(move.before.removesuffix(".mcap"), move.after.removesuffix(".mcap")) for move in moves]


def placed(guided: GuideRig, *positions: int) -> None:
    for position in positions:
        guided.hands(f"place {position} 8")
        guided.run(guided.done(guided.view.done + 1))


def test_no_row_is_missing_from_the_first_step_to_the_last(rig: Make) -> None:
    guided = rig([*dwells(1, 2, 3), Turn("y", "+", 1, 5, 3.0)])
    placed(guided, 1, 2, 3)
    guided.hands("place 5 8")
    guided.run(lambda v: v.turn is not None and v.turn.rest_s >= 3.0)
    guided.hands("turn y + 1 3")
    guided.run(guided.done(4))
    assert carried(guided) == [("dwell_01", "dwell_02"), ("dwell_02", "dwell_03"), ("dwell_03", "turn_y_plus")]
    read = read_campaign(guided.folder).campaign
    series = sorted((each.series for each in (*read.dwells, *read.turns, *read.moves)), key=lambda s: s.t[0])
    t = np.concatenate([each.t for each in series])
    assert np.diff(t) == pytest.approx(0.02)
    assert len(t) == round((t[-1] - t[0]) / 0.02) + 1


@pytest.mark.parametrize(("fault", "why"), [("lost", LOST), ("unplug", ANEW), ("restart", "switched off and on")])
def test_a_broken_stream_breaks_one_move_and_says_so(rig: Make, fault: str, why: str) -> None:
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1)
    guided.hands("place 2 8")
    guided.rest(4.0)
    guided.source.device.plant(fault, 3, 3.0)
    guided.run(guided.done(2))
    assert any("no move to it" in text and why in text for text in guided.texts), guided.texts
    assert why in guided.view.step("dwell_02").note
    placed(guided, 3)
    assert carried(guided) == [("dwell_02", "dwell_03")]


def test_a_redone_dwell_takes_its_moves_with_it(rig: Make) -> None:
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1, 2, 3)
    guided.obey("redo", step="dwell_02")
    guided.hands("place 2 8")
    guided.run(lambda v: v.step("dwell_02").attempts == 2)
    assert carried(guided) == [("dwell_03", "dwell_02_2")]


def test_a_resumed_campaign_has_no_move_over_the_break(rig: Make) -> None:
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1)
    guided.resume()
    placed(guided, 2, 3)
    assert carried(guided) == [("dwell_02", "dwell_03")]
    assert any(INTERRUPTED in text for text in guided.texts)
    guided.resume()
    assert INTERRUPTED in guided.view.step("dwell_02").note
    assert guided.view.step("dwell_03").note == ""


def test_no_move_leads_to_or_from_a_rest_that_no_solve_places(rig: Make) -> None:
    guided = rig([*dwells(1), Monitor(1, 5.0, 3, ("joint",)), *dwells(5)])
    placed(guided, 1, 3, 5)
    assert carried(guided) == []
    assert not any("no move" in text for text in guided.texts)


def test_a_move_that_takes_too_long_is_let_go() -> None:
    chain = MoveChain(is_resumed=False)
    chain.begin(Dwell(1, 1.0), "dwell_01.mcap", SAMPLES, TAPE)
    there = chain.move_to(Dwell(2, 1.0), 5 * SAMPLES, TAPE, 0.02)
    assert there == MovedFrom("dwell_01.mcap", (SAMPLES, 5 * SAMPLES))
    assert chain.oldest == SAMPLES
    chain.look(TAPE, 12 * SAMPLES, 1.1)
    assert chain.why == LONG
    assert chain.oldest is None
    assert chain.move_to(Dwell(2, 1.0), 12 * SAMPLES, TAPE, 0.02) is None

"""Moves between accepted steps: every row in between, none where anything breaks them, also after a kill."""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Monitor, Turn
from procedures.twelve_positions.placement_transfers import MAX_CONING_RAD, coning_of, long_enough_s
from procedures.units import RAD_PER_ARCSEC
from station.files.campaign_folder import plan_file
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.guide.checks.transfers import INTERRUPTED, LONG, LOST, RESTARTED, TransferChain
from station.stream.recorder import accepted_step_writer as recording
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


@pytest.mark.parametrize(
    ("fault", "why"), [("lost", LOST), ("unplug", RESTARTED), ("restart", "switched off and on")]
)
def test_a_broken_stream_breaks_one_move_and_says_so(rig: Make, fault: str, why: str) -> None:
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1)
    guided.hands("place 2 8")
    guided.rest(4.0)
    guided.source.device.plant(fault, 3, 3.0)
    guided.run(guided.done(2))
    assert any("no transfer to it" in text and why in text for text in guided.texts), guided.texts
    assert why in guided.view.step("dwell_02").note
    placed(guided, 3)
    assert carried(guided) == [("dwell_02", "dwell_03")]


def test_a_redone_dwell_takes_its_moves_with_it(rig: Make) -> None:
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1, 2, 3)
    guided.execute("redo", step="dwell_02")
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
    chain = TransferChain(is_resumed=False)
    chain.begin(Dwell(1, 1.0), "dwell_01.mcap", SAMPLES, TAPE)
    there = chain.move_to(Dwell(2, 1.0), 5 * SAMPLES, TAPE, 0.02)
    assert there == MovedFrom("dwell_01.mcap", (SAMPLES, 5 * SAMPLES))
    assert chain.oldest == SAMPLES
    chain.look(TAPE, 12 * SAMPLES, 1.1)
    assert chain.why == LONG
    assert chain.oldest is None
    assert chain.move_to(Dwell(2, 1.0), 12 * SAMPLES, TAPE, 0.02) is None


class Killed(BaseException):
    """The process ends here."""


# which write, which call of it, whether the process dies once it is done, and whether the step counts then
KILLS: dict[str, tuple[object, str, int, bool, bool]] = {
    "before the move has its name": (os, "rename", 1, False, False),
    "before the move's hash": (recording, "append_hash", 1, False, False),
    "between the move's file and the step's": (recording, "append_hash", 1, True, False),
    "before the step has its name": (os, "rename", 2, False, False),
    "before the step's hash": (recording, "append_hash", 2, False, False),
    "between the step's file and campaign.toml": (recording, "write_tables", 1, False, False),
    "between campaign.toml and the row": (recording, "write_tables", 1, True, True),
    "before the commit": (recording, "accept_step", 1, True, True),
    "after the commit, before the note of a missing move": (plan_file, "write_note", 1, False, True),
}


def killed_at(monkeypatch: pytest.MonkeyPatch, point: str) -> None:
    """Have the process die at the point named."""
    owner, name, number, is_after, _ = KILLS[point]
    real, calls = getattr(owner, name), [0]

    def dying(*a: object, **k: object) -> object:
        calls[0] += 1
        if calls[0] != number:
            return real(*a, **k)
        if is_after:
            real(*a, **k)
        return _die()

    monkeypatch.setattr(owner, name, dying)


def _die() -> NoReturn:
    raise Killed


@pytest.mark.parametrize("point", [one for one in KILLS if "between" in one])
def test_after_a_kill_the_next_step_has_no_move_and_the_others_keep_theirs(
    rig: Make, monkeypatch: pytest.MonkeyPatch, point: str
) -> None:
    guided = rig(dwells(1, 2, 3, 5))
    placed(guided, 1, 2)
    with monkeypatch.context() as patch:
        killed_at(patch, point)
        with pytest.raises(Killed):
            placed(guided, 3)
    guided.resume()
    counts = KILLS[point][4]
    before = [("dwell_01", "dwell_02"), *([("dwell_02", "dwell_03")] if counts else [])]
    assert carried(guided) == before
    assert guided.view.done == 2 + counts
    placed(guided, *([] if counts else [3]), 5)
    first = "dwell_05" if counts else "dwell_03"
    assert INTERRUPTED in guided.view.step(first).note
    assert [to for _, to in carried(guided)].count(first) == 0
    after = [] if counts else [("dwell_03", "dwell_05")]
    names = [(before_.split("_2")[0], to.split("_2")[0]) for before_, to in carried(guided)]
    assert names == [*before, *after]


@pytest.mark.parametrize("point", ["before the step has its name", "between campaign.toml and the row"])
def test_a_kill_while_a_step_is_done_again_leaves_its_old_moves_or_none(
    rig: Make, monkeypatch: pytest.MonkeyPatch, point: str
) -> None:
    """A step that follows itself has no move, so that its own writes are the first."""
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1, 2)
    guided.execute("redo", step="dwell_02")
    owner, name, _, is_after, counts = KILLS[point]
    with monkeypatch.context() as patch:
        monkeypatch.setitem(KILLS, point, (owner, name, 1, is_after, counts))
        killed_at(patch, point)
        guided.hands("place 2 8")
        with pytest.raises(Killed):
            guided.run(lambda v: v.step("dwell_02").attempts == 2)
    guided.resume()
    assert carried(guided) == ([] if counts else [("dwell_01", "dwell_02")])
    guided.execute("redo", step="dwell_02")
    guided.hands("place 2 8")
    guided.run(lambda v: v.step("dwell_02").attempts == 2 + counts)
    assert carried(guided) == []
    placed(guided, 3)
    assert [to for _, to in carried(guided)] == ["dwell_03"]


SLOW = replace(Truth.example(1), sample_period_s=0.1)  # 10 Hz, too few for a hand's tremor


def test_a_fast_flip_is_reported_at_once_and_a_slow_one_is_not(rig: Make) -> None:
    guided = rig(dwells(1, 4, 2, seconds=30.0), SLOW)
    guided.run(guided.done(1))
    guided.hands("carry 4 3 60")
    view = guided.run(lambda v: any("moved too fast" in e.text for e in v.events), seconds=60)
    assert view.done == 1  # before the dwell is over
    [reported] = [e.text for e in view.events if "moved too fast" in e.text]
    assert "arcsec of coning; at least" in reported
    assert reported.endswith("s for a flip")
    guided.run(guided.done(2))
    assert "its transfer is not used" in guided.view.step("dwell_04").note
    guided.hands("carry 2 60 0")
    guided.run(guided.done(3))
    assert sum("moved too fast" in text for text in guided.texts) == 1
    moves = read_campaign(guided.folder).campaign.moves
    k = float(np.mean(SLOW.gyro_k))
    left = [coning_of(move.series, k * np.eye(3), np.zeros(3)) for move in moves]
    assert left[0] > MAX_CONING_RAD > left[1]


def test_the_time_that_is_enough_grows_with_the_fourth_root_of_the_error() -> None:
    assert long_enough_s(16 * MAX_CONING_RAD, 3.0) == pytest.approx(6.0)
    assert pytest.approx(2 * RAD_PER_ARCSEC) == MAX_CONING_RAD

"""A kill at each write of accepting a step with its move: what is gone on with has no move that nobody made."""

import os
from collections.abc import Callable
from typing import NoReturn

import pytest

from station.files.campaign_folder import notes
from station.guide.move_chain import INTERRUPTED
from station.stream.recorder import accepted_step_writer as recording
from tests.station.guide.rig import GuideRig, dwells
from tests.station.guide.test_move_chain import carried, placed

Make = Callable[..., GuideRig]


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
    "after the commit, before the note of a missing move": (notes, "write_note", 1, False, True),
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


@pytest.mark.parametrize("point", [one for one in KILLS if "note" not in one])
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


@pytest.mark.parametrize("point", [one for one in KILLS if "move" not in one])
def test_a_kill_while_a_step_is_done_again_leaves_its_old_moves_or_none(
    rig: Make, monkeypatch: pytest.MonkeyPatch, point: str
) -> None:
    """A step that follows itself has no move, so that its own writes are the first."""
    guided = rig(dwells(1, 2, 3))
    placed(guided, 1, 2)
    guided.obey("redo", step="dwell_02")
    owner, name, _, is_after, counts = KILLS[point]
    with monkeypatch.context() as patch:
        monkeypatch.setitem(KILLS, point, (owner, name, 1, is_after, counts))
        killed_at(patch, point)
        guided.hands("place 2 8")
        with pytest.raises(Killed):
            guided.run(lambda v: v.step("dwell_02").attempts == 2)
    guided.resume()
    assert carried(guided) == ([] if counts else [("dwell_01", "dwell_02")])
    guided.obey("redo", step="dwell_02")
    guided.hands("place 2 8")
    guided.run(lambda v: v.step("dwell_02").attempts == 2 + counts)
    assert carried(guided) == []
    placed(guided, 3)
    assert [to for _, to in carried(guided)] == ["dwell_03"]

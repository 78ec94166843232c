"""Two short campaigns of the simulated year, one of them twice; whole ones are `python -m tests.year`."""

from pathlib import Path

from procedures.campaign.plan_steps import Dwell
from tests.year.night import Outcome, one_campaign

SIX_FACES = (1, 3, 5, 7, 9, 11)


def short_campaign(folder: Path, number: int, *positions: int) -> Outcome:
    folder.mkdir()
    return one_campaign(folder, 1, number, [Dwell(position, 6.0) for position in positions])


def test_a_campaign_that_is_killed_leaves_what_it_showed(tmp_path: Path) -> None:
    outcome = short_campaign(tmp_path / "a", 2602, *SIX_FACES)
    assert not outcome.finding, outcome.log[-20:]
    assert outcome.kills
    assert outcome.ended == "FAIL"  # six dwells of 6 s tell too little for its limits


def test_a_seed_replays_to_the_byte(tmp_path: Path) -> None:
    one, again = (short_campaign(tmp_path / name, 2602, 1) for name in ("a", "b"))
    assert one.kills
    assert "accepted dwell_01" in "".join(one.log)
    assert one.log == again.log

"""Two short campaigns of the simulated year, one of them twice; whole ones are `python -m tests.year`."""

from pathlib import Path

import numpy as np

from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import accept_calibration
from fixtures_db.verification import alterations
from procedures.campaign.plan_steps import Dwell, Turn
from tests.fixtures_db.factory import facts, fill_fixtures, solution
from tests.year.night import Outcome, one_campaign
from tests.year.older_database import take_back
from tests.year.plans import WHOLE_SHARE, drawn_plan

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


def test_what_an_older_program_cannot_have_stored_is_not_taken_back(tmp_path: Path) -> None:
    file = tmp_path / "station.db"
    open_db(file).close()
    assert take_back(file)
    with open_db(file) as database, database.write() as session:
        fill_fixtures(session)
        accept_calibration(session, solution(), facts())
    assert not take_back(file)
    with open_db(file) as database, database.read() as session:
        assert not list(alterations(session))


def test_plans_see_every_face_and_some_are_whole() -> None:
    plans = [drawn_plan(np.random.default_rng([1, number]), 6.0) for number in range(400)]
    short = [[step.position for step in plan if isinstance(step, Dwell)] for plan in plans if plan]
    assert 0.5 < (len(plans) - len(short)) / (400 * WHOLE_SHARE) < 1.5
    assert all({(position - 1) // 2 for position in positions} == set(range(6)) for positions in short)
    assert all(7 <= len(positions) == len(set(positions)) <= 9 for positions in short)
    assert 0 < sum(any(isinstance(step, Turn) for step in plan) for plan in plans) < len(short) / 2

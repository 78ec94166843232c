"""How long the hands of this station take, from when the steps of its campaigns were accepted."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from fixtures_db.campaigns import complete_campaigns
from fixtures_db.database import Database
from fixtures_db.schema import CampaignRow
from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.planning.campaign_design import HandTimes
from station.errors import DataRefused
from station.files.campaign_folder.plan_file import kept_plan

FEWEST_TIMES = 6  # placings, or turns, that were timed, below which the stated default stands
LEAST_S, MOST_S = 10.0, 300.0  # s: what is quicker was simulated, what is slower was a break
NEWEST = 20  # campaigns


def hand_times(database: Database) -> tuple[HandTimes, str]:
    """Return how long placings and turns take on the median, and where that is from, in words."""
    placements, turns = list[float](), list[float]()
    with database.read() as session:
        for row in list(complete_campaigns(session))[-NEWEST:]:
            for step, seconds in _timed(row):
                (turns if isinstance(step, Turn) else placements).append(seconds)
    usual = HandTimes()
    if len(placements) < FEWEST_TIMES:
        return (
            usual,
            f"{usual.placing:g} s per placement as stated: {len(placements)} were timed here, {FEWEST_TIMES} are "
            "needed",
        )
    placing = float(np.median(placements))
    turn = float(np.median(turns)) if len(turns) >= FEWEST_TIMES else usual.turn
    said = f"{placing:.0f} s per placement, the median of {len(placements)} of this station"
    return HandTimes(placing, placing * usual.move / usual.placing, turn), said


def _timed(row: CampaignRow) -> Sequence[tuple[Step, float]]:
    """Return dwells and turns with what they took beside recording, from the step accepted before."""
    try:
        steps = {step.name: step for step in kept_plan(Path(row.folder))}
    except (DataRefused, OSError):
        return ()
    accepted = [step for step in row.steps if not step.superseded]
    found = list[tuple[Step, float]]()
    for before, after in pairwise(accepted):
        step = steps.get(after.name)
        if isinstance(step, Dwell | Turn):
            recorded = step.seconds if isinstance(step, Dwell) else 0.0
            seconds = (after.accepted_utc - before.accepted_utc).total_seconds() - recorded
            if LEAST_S <= seconds <= MOST_S:
                found.append((step, seconds))
    return found

"""What the accepted steps of a campaign that is gone on with leave for those after them."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign import TurnRecord
from procedures.frames import AXES
from procedures.steps import FreePosition, Soak, Turn
from station.campaign_folder import read_campaign
from station.guide.checklist import is_free
from station.guide.rested import Rested, rested
from station.live.counted import counted_series
from station.recorder.campaign import step_of


def so_far(folder: Path) -> tuple[list[Rested], dict[str, float], dict[str, float], dict[str, FloatArray]]:
    """Return what the accepted steps leave for those after them.

    Dwells; turns by counts per revolution; how long each step is [s]; free attitudes by count rates (3,).
    """
    folder_read = read_campaign(folder)
    loaded = folder_read.campaign
    before = [rested(d.position, counted_series(d.series)) for d in loaded.dwells]
    turns = {_name(turn): _counts_per_revolution(turn, loaded.fixture.C_ib) for turn in loaded.turns}
    seconds, leaned = dict[str, float](), dict[str, FloatArray]()
    for one in folder_read.steps:
        if (step := step_of(one.table)) is None or one.data is None:
            continue
        series = one.data.series
        seconds[step.name] = len(series) * series.period
        if isinstance(step, FreePosition | Soak) and is_free(step):
            leaned[step.name] = np.asarray(counted_series(series).accel).mean(axis=0) / series.period
    return before, turns, seconds, leaned


def _name(turn: TurnRecord) -> str:
    return Turn(turn.axis, turn.direction, turn.revolutions, turn.start_position, 0.0).name


def _counts_per_revolution(turn: TurnRecord, C_ib: FloatArray) -> float:
    """Return it as `station.live.turning.TurnWatch` saw it: less the rate of the first seconds, at rest."""
    series = counted_series(turn.series)
    samples = np.asarray(series.gyro) @ C_ib[:, AXES.index(turn.axis)]
    rest = samples[: max(round(2.0 / series.period), 1)].mean()
    return abs(float(np.sum(samples - rest))) / turn.revolutions

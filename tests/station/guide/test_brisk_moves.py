"""A move too brisk for its sample rate: said when the cube rests again, recorded, left out by the solve."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from procedures.dwells_and_turns.brisk_moves import MAX_CONING_RAD, coning_of, long_enough_s
from procedures.units import RAD_PER_ARCSEC
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]
SLOW = replace(Truth.example(1), sample_period_s=0.1)  # 10 Hz, too few for a hand's tremor


def test_a_brisk_flip_is_told_at_once_and_a_slow_one_is_not(rig: Make) -> None:
    guided = rig(dwells(1, 4, 2, seconds=30.0), SLOW)
    guided.run(guided.done(1))
    guided.hands("carry 4 3 60")
    view = guided.run(lambda v: any("too brisk" in e.text for e in v.events), seconds=60)
    assert view.done == 1  # before the dwell is over
    [said] = [e.text for e in view.events if "too brisk" in e.text]
    assert "arcsec of coning; at least" in said
    assert said.endswith("s for a flip")
    guided.run(guided.done(2))
    assert "its move is left out" in guided.view.step("dwell_04").note
    guided.hands("carry 2 60 0")
    guided.run(guided.done(3))
    assert sum("too brisk" in text for text in guided.texts) == 1
    moves = read_campaign(guided.folder).campaign.moves
    k = float(np.mean(SLOW.gyro_k))
    left = [coning_of(move.series, k * np.eye(3), np.zeros(3)) for move in moves]
    assert left[0] > MAX_CONING_RAD > left[1]


def test_the_time_that_is_enough_grows_with_the_fourth_root_of_the_error() -> None:
    assert long_enough_s(16 * MAX_CONING_RAD, 3.0) == pytest.approx(6.0)
    assert pytest.approx(2 * RAD_PER_ARCSEC) == MAX_CONING_RAD

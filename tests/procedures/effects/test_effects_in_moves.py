"""What every effect turns a move by, against the simulator's own counts of the cube carried from step to step."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps
from procedures.campaign.plan_steps import turn_steps
from procedures.evidence.residual_rows import evidence_of
from procedures.frames import rotation_vector
from procedures.twelve_positions.transfer_rotation import finer_moves
from tests.procedures.effects.test_every_effect import CASES, UNIT, Baseline, carried_out, predicted

CARRIED = replace(UNIT, sample_period_s=0.02)
AT_ITS_END_S = 192.0  # of device time: where the sixth position's dwell ends and its move begins
FLOOR_DEG = 2e-6  # deg: 0.007 arcsec
NOTHING = {"accelerometer", "clock", "site.gravity"}  # no effect of theirs turns a move
IN_MOVES = [
    case for case in CASES if not {case[0], case[0].partition(".")[0]} & NOTHING and case[0] != "auxiliary.channel"
]


def carried(effects: Mapping[str, Mapping[str, float]]) -> ReducedSteps:
    """A campaign without noise whose moves are recorded, and three of six turns."""
    return carried_out(effects, CARRIED, moves=True, free=(), turns=turn_steps(1, 2.0)[::2])


@cache
def baseline() -> Baseline:
    steps = carried({})
    fits = fit_reduced(steps)
    return Baseline(steps, fits, evidence_of(fits))


def turned_otherwise(effects: Mapping[str, Mapping[str, float]]) -> FloatArray:
    """By how much the moves (m, 3) [deg] turned otherwise than without the effects."""
    gyroscope = baseline().fits.gyroscope
    assert gyroscope is not None
    K, b = gyroscope.joint.K, gyroscope.joint.b
    before, after = (
        finer_moves([move.series for move in each.campaigns[0].moves]).integrate(K, b).rotation
        for each in (baseline().steps, carried(effects))
    )
    return np.degrees(rotation_vector(before @ np.swapaxes(after, 1, 2)))


@pytest.mark.parametrize("case", IN_MOVES, ids=lambda case: f"{case[0]} {case[4]}")
def test_a_planted_effect_turns_the_moves_by_its_columns(case) -> None:
    name, sizes, coefficients, where, shape = case
    planted = {**sizes, "after_s": AT_ITS_END_S} if "after_s" in sizes else sizes
    got = turned_otherwise({name: planted}).ravel()
    evidence = baseline().evidence
    expected = predicted(name, coefficients or sizes, where, shape, evidence)[evidence.rows("move")]
    assert np.linalg.norm(expected) > 10 * FLOOR_DEG
    assert np.linalg.norm(got - expected) < 0.03 * np.linalg.norm(expected) + FLOOR_DEG * np.sqrt(len(got))

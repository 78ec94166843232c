"""Moves too brisk for their sample rate are left out of a solve, which says so and does as well without them."""

from dataclasses import replace

import numpy as np

from procedures.calibration.triad_calibration import triad_vector
from procedures.dwells_and_turns.gyroscopes_joint_fit import solve_gyroscope
from procedures.dwells_and_turns.twelve_position import solve_accelerometer
from tests.procedures.dwells_and_turns.carried_cube import campaign

ORDER = tuple("ENU ESD USE DSW SUW NDW NWU SWD UWS DES EUS EDN".split())


def test_brisk_moves_are_left_out_and_said_and_the_others_solve() -> None:
    slow, brisk = campaign(3, ORDER, seconds=25.0, hz=50.0), campaign(3, ORDER, seconds=4.0, hz=12.5)
    moves = (*slow.campaign.moves[:-1], brisk.campaign.moves[-1])
    made = replace(slow, campaign=replace(slow.campaign, moves=moves))
    accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
    fit = solve_gyroscope([made.campaign], made.gyroscope, [], accelerometer)
    assert fit is not None
    assert fit.moves is not None
    [said] = fit.moves.moves.left_out
    assert said.startswith("move_10 left out: too brisk, ")
    assert said.endswith(" arcsec of coning")
    assert len(fit.moves.moves.records) == 10
    vector = triad_vector(fit.joint, "gyroscope", accelerometer)
    off = (vector.value - made.truth)[:3] / np.sqrt(np.diag(vector.covariance))[:3]
    assert np.abs(off).max() < 4


def test_without_a_move_that_is_slow_enough_nothing_is_solved_and_nothing_raised() -> None:
    made = campaign(3, ORDER, seconds=4.0, hz=12.5)
    accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
    assert solve_gyroscope([made.campaign], made.gyroscope, [], accelerometer) is None

"""Moves too brisk for their sample rate are left out of a solve, which says so and does as well without them."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.carried_by_hand import carry
from procedures.calibration.triad_calibration import triad_vector
from procedures.counts.sample_records import RateSeries
from procedures.dwells_and_turns.finer_moves import finer_moves
from procedures.dwells_and_turns.gyroscopes_joint_fit import solve_gyroscope
from procedures.dwells_and_turns.twelve_position import solve_accelerometer
from procedures.frames import nominal_C_lb, rotation_vector
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


def carried(seed: int, hz: float, seconds: float, pause_s: float) -> tuple[np.ndarray, float]:
    """Return a carried cube's rotation less what is integrated [rad], and 1 sigma of what coning leaves of it."""
    rng = np.random.default_rng(seed)
    before, after = (nominal_C_lb(int(p)).T for p in rng.choice(range(1, 13), 2, replace=False))
    samples = round(seconds * hz)
    held = carry(before, after, samples, 1 / hz, rng, float(rng.uniform(20, 60)), pause_s)
    t, still = np.arange(1, samples + 1) / hz, np.zeros((samples, 3))
    series = RateSeries(t, np.degrees(held.rates), still, np.zeros(samples), 1 / hz, np.array([0]))
    moves, at = finer_moves([series]), (np.eye(3), np.zeros(3))
    seen = moves.integrate(*at).rotation[0]
    return rotation_vector(seen @ (after @ before.T).T), float(moves.coning(*at)[0])


@pytest.mark.parametrize("seconds", [10.0, 20.0])
def test_what_coning_leaves_is_in_its_sigma_where_a_hand_trembles_and_stops(seconds: float) -> None:
    found = [carried(seed, 50.0, seconds, 2.0) for seed in range(20)]
    z = np.array([error / sigma for error, sigma in found])
    assert np.sqrt(np.mean(z**2)) < 2.0
    assert np.abs(z).max() < 7  # it stops within no time, which no hand does

"""You and Lee, section 4, run again: what comes out as printed and what not (docs/explanation/attitude.md)."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog, down_of, roll_pitch_of
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY
from tests.drivers.simulated.flight import FORCE_UG, GYRO_DEG_H, LEVEL_S, paper_flight

SEEDS = range(6)
flight = cache(paper_flight)


def by(aid: str) -> Callable[[AttitudeLog], FloatArray]:
    return lambda log: estimate(log, aid).down


def errors_deg(log: AttitudeLog, down: FloatArray) -> FloatArray:
    roll, pitch = roll_pitch_of(down)
    assert log.roll is not None
    assert log.pitch is not None
    return np.degrees(np.stack([roll - log.roll, pitch - log.pitch], axis=1))


def maxima(aid: str, turn_s: float = 50.0, attack_deg: float = 3.0) -> tuple[FloatArray, FloatArray]:
    """Return the mean over seeds of the largest roll and pitch error in level flight and in the turn [deg]."""
    level, turn = [], []
    for seed in SEEDS:
        log = flight(seed, turn_s, 200.0, attack_deg)
        error = np.abs(errors_deg(log, by(aid)(log)))
        level.append(error[(log.t > 20) & (log.t < LEVEL_S)].max(axis=0))
        turn.append(error[log.t > LEVEL_S].max(axis=0))
    return np.mean(level, axis=0), np.mean(turn, axis=0)


def test_figure_3_the_gyros_alone_drift_with_time() -> None:
    drift = []
    for seed in SEEDS:
        log = flight(seed, 50.0, 200.0, 3.0)
        error = errors_deg(log, ComplementaryFilter(ComplementaryGains(1e-9, 0.0)).run(log))
        drift.append([error[12499], error[24999]])
    at_125, at_250 = np.sqrt(np.mean(np.square(drift), axis=(0, 2)))
    one_sigma = 50 * 250 / 3600  # 50 deg/h over 250 s
    assert at_250 == pytest.approx(one_sigma, rel=4 / np.sqrt(2 * 2 * len(SEEDS)))
    assert at_250 / at_125 == pytest.approx(2, rel=0.2)  # "almost linearly"


def test_figure_4_forward_speed_stays_below_1_deg_in_level_flight_and_grows_in_the_turn() -> None:
    level, turn = maxima("paper-airspeed")
    assert (level < 1.0).all()
    assert turn[0] > 2.0
    assert turn[1] > 1.0


def filtered(variance: float) -> FloatArray:
    """Return the mean over seeds of the velocity filter's largest roll and pitch error in the turn [deg]."""
    found = []
    for seed in SEEDS:
        log = flight(seed, 50.0, 200.0, 3.0)
        law = ComplementaryFilter(aid="paper-filter", velocity_variance=variance)
        roll, pitch = law.run(log).T
        found.append(np.abs(errors_deg(log, down_of(roll, pitch)))[log.t > LEVEL_S].max(axis=0))
    mean: FloatArray = np.mean(found, axis=0)
    return mean


@pytest.mark.parametrize("variance", [1e-6, 100.0])
def test_figure_5_the_velocity_filter_reduces_both_whatever_its_first_covariance(variance: float) -> None:
    _, before = maxima("paper-airspeed")
    after = filtered(variance)
    assert after[0] < 0.3 * before[0]
    assert after[1] < 0.3 * before[1]


@pytest.mark.parametrize("aid", ["paper-airspeed", "airspeed", "paper-airspeed-rate", "paper-filter"])
def test_the_filter_settles_at_the_error_of_the_accelerometers_angle(aid: str) -> None:
    """Equation 8, a minute and more into a turn: told from what the law leaves out, against the truth."""
    for seed in range(3):
        log = flight(seed, 300.0, 200.0, 3.0)
        assert log.airspeed is not None
        law, predicted, wrong = ComplementaryFilter(aid=aid), [], []
        settled, end = np.searchsorted(log.t, (400.0, 500.0))
        for rows in np.split(np.arange(end), np.arange(settled, end, 10)):
            law.run(AttitudeLog(log.t[rows], log.omega_b[rows], log.f_b[rows], log.airspeed[rows]))
            if rows[0] >= settled:
                reported = law.final_bias(FORCE_UG * 1e-6 * STANDARD_GRAVITY, GYRO_DEG_H * RAD_S_PER_DEG_H)
                assert reported is not None
                predicted.append([reported.roll, reported.pitch, reported.roll_std, reported.pitch_std])
                wrong.append(np.subtract(law.attitude, down_angles(log, int(rows[-1]))))
        bias, std = np.mean(predicted, axis=0)[:2], np.mean(predicted, axis=0)[2:]
        assert (np.abs(np.mean(wrong, axis=0) - bias) < 3 * std).all()
        if aid == "paper-airspeed":
            assert bias[1] > 4 * std[1]  # it is no nought that is held against a wide sigma


def down_angles(log: AttitudeLog, row: int) -> tuple[float, float]:
    """Return the true roll and pitch [rad] at a row."""
    assert log.roll is not None
    assert log.pitch is not None
    return float(log.roll[row]), float(log.pitch[row])

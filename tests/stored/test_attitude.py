"""Attitude of one drive by every aid of the complementary laws and the Kalman filter, with biases and sigmas."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.attitude.attitude_diagnosis import diagnose_attitude
from procedures.attitude.attitude_estimate import AIDS, default_aid, estimate, estimate_both_directions
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import disagreement
from procedures.attitude.complementary_gains import PAPER_GAINS
from procedures.attitude.complementary_velocity_aids import observability
from procedures.attitude.gain_tuning import grid_of_taus, tune
from procedures.attitude.kalman.unaided_motion import heading_at_rest
from procedures.attitude.sensor_noise import clipping_limits, gyro_noise
from tests.stored.attitude_log import G, drive
from tests.stored.conftest import StoredResult

LOG = drive()


def with_a_gap(log: AttitudeLog) -> AttitudeLog:
    rows = np.flatnonzero((log.t < 20) | (log.t > 22.5))
    names = ("t", "omega_b", "f_b", "airspeed", "velocity", "roll", "pitch", "heading")
    return replace(log, **{name: getattr(log, name)[rows] for name in names if getattr(log, name) is not None})


@pytest.mark.parametrize("aid", AIDS)
def test_each_aid(stored_result: StoredResult, aid: str) -> None:
    stored_result.check(estimate(LOG, aid))


def test_the_filter_with_all_options_over_a_gap(stored_result: StoredResult) -> None:
    log = with_a_gap(replace(LOG, heading=np.where(np.arange(len(LOG.t)) % 25 == 24, 0.3, np.nan)))
    found = estimate(
        log, "gnss", gravity=9.81, latitude=0.8, gyro_bias_std=1e-3, force_bias_std=0.02, fix_latency=0.1,
        learns_motion=False,
    )  # fmt: skip
    stored_result.check(found)


@pytest.mark.parametrize("aid", ["airspeed", "gnss"])
def test_the_diagnosis_of_an_attitude(stored_result: StoredResult, aid: str) -> None:
    log = drive(70.0, fix_s=0.1)
    log = replace(log, omega_b=log.omega_b * [1.003, 1.0, 0.998] + 1e-4 * log.f_b[:, [1, 2, 0]])
    found = diagnose_attitude(log, aid, PAPER_GAINS if aid == "airspeed" else None, G)
    stored_result.check(found, without=["log_p"])


def test_both_directions_and_tuned_gains(stored_result: StoredResult) -> None:
    tuned = tune(LOG, "airspeed", grid_of_taus((2.0, 10.0, 60.0)))
    stored_result.check({"both": estimate_both_directions(LOG, "gnss", G), "tuned": tuned})


def test_what_a_log_shows_of_itself(stored_result: StoredResult) -> None:
    first = {name: getattr(LOG, name)[:300] for name in ("t", "omega_b", "f_b")}
    still = replace(LOG, **first, airspeed=None, velocity=None, roll=None, pitch=None)
    stored_result.check({
        "aids": [default_aid(LOG), default_aid(still)], "gaps": with_a_gap(LOG).gaps, "noise": gyro_noise(LOG),
        "clipped": clipping_limits(LOG), "axes": disagreement(LOG), "heading": heading_at_rest(still, 0.8, 1e-5),
        "observability": observability(LOG, 0.05),
    })  # fmt: skip

"""Roll and pitch of one drive by every law, aid and setting, down to the biases and sigmas."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import AIDS, default_aid, estimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import disagreement
from procedures.attitude.both_directions import estimate_both_directions
from procedures.attitude.complementary_gains import PAPER_GAINS, Gains
from procedures.attitude.diagnosis.attitude_diagnosis import diagnose_attitude
from procedures.attitude.final_bias import final_bias
from procedures.attitude.gain_tuning import grid_of_gains, grid_of_taus, tune
from procedures.attitude.heading_at_rest import heading_at_rest, resting_rows
from procedures.attitude.observability import observability
from procedures.attitude.sensor_noise import clipped_rows, gate_of, gyro_noise
from tests.stored.attitude_log import G, drive
from tests.stored.held import assert_held

LOG = drive()


def with_a_gap(log: AttitudeLog) -> AttitudeLog:
    rows = np.flatnonzero((log.t < 20) | (log.t > 22.5))
    names = ("t", "omega_b", "f_b", "airspeed", "velocity", "roll", "pitch", "heading")
    return replace(log, **{name: getattr(log, name)[rows] for name in names if getattr(log, name) is not None})


@pytest.mark.parametrize("aid", AIDS)
def test_each_aid(aid: str) -> None:
    assert_held("attitude", f"aid {aid}", estimate(LOG, aid))


@pytest.mark.parametrize("aid", ["none", "airspeed-filter", "gnss"])
def test_the_filter_with_all_that_can_be_said(aid: str) -> None:
    log = with_a_gap(replace(LOG, heading=np.where(np.arange(len(LOG.t)) % 25 == 24, 0.3, np.nan)))
    told = estimate(
        log, aid, gravity=9.81, latitude=0.8, gyro_bias_std=1e-3, force_bias_std=0.02, fix_latency=0.1,
        learns_motion=False,
    )  # fmt: skip
    assert_held("attitude", f"filter {aid}, all said", told)


@pytest.mark.parametrize("aid", ["airspeed", "gnss"])
def test_what_the_law_lacks(aid: str) -> None:
    log = drive(70.0, fix_s=0.1)
    log = replace(log, omega_b=log.omega_b * [1.003, 1.0, 0.998] + 1e-4 * log.f_b[:, [1, 2, 0]])
    found = diagnose_attitude(log, aid, PAPER_GAINS if aid == "airspeed" else None, G)
    assert_held("attitude", f"diagnosis by {aid}", found, (".tried.log_p",))


def test_gains_tuned_to_the_truth() -> None:
    candidates = grid_of_taus((2.0, 10.0, 60.0))
    assert_held("attitude", "tuned", [tune(LOG, "airspeed", candidates), grid_of_gains()[::10]])


def test_the_mixing_law_with_other_gains() -> None:
    assert_held("attitude", "mixer, other gains", estimate(LOG, "none", Gains(0.7, 0.03)))


def test_a_vehicle_without_aid_over_a_gap() -> None:
    assert_held("attitude", "none over a gap", estimate(with_a_gap(LOG), "none"))


def test_there_and_back() -> None:
    assert_held("attitude", "both directions", estimate_both_directions(LOG, "gnss", G))


def test_what_a_log_says_of_itself() -> None:
    still = replace(LOG, **{name: getattr(LOG, name)[:300] for name in ("t", "omega_b", "f_b")}, airspeed=None,
                    velocity=None, roll=None, pitch=None)  # fmt: skip
    said = {
        "aids": [default_aid(LOG), default_aid(still)], "gaps": with_a_gap(LOG).gaps, "noise": gyro_noise(LOG),
        "gate": gate_of(gyro_noise(LOG)), "clipped": clipped_rows(LOG), "axes": disagreement(LOG),
        "rest": resting_rows(LOG), "heading": heading_at_rest(still, 0.8, 1e-5),
        "observability": observability(LOG, 0.05),
    }  # fmt: skip
    assert_held("attitude", "the log itself", said)
    final = final_bias((0.2, -0.3), (0.02, 0.03), (0.4, -0.1), G)
    assert final.roll == pytest.approx(0.3 / G / np.cos(0.1) / np.cos(0.4))
    assert final.pitch == pytest.approx(0.2 / G / np.cos(0.1))
    assert final.roll_std == pytest.approx(final.roll / 10)
    assert final.pitch_std == pytest.approx(final.pitch / 10)

"""The loop closed for attitude: what is planted in a drive is found, named, corrected, and nothing else."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.attitude.attitude_diagnosis import diagnose_attitude
from procedures.attitude.attitude_effects import NAMED, AttitudeMotion
from procedures.attitude.attitude_log import AttitudeLog
from procedures.errors import ErrorCode, NotObservable
from tests.procedures.attitude.driving import G, with_truth
from tests.refusals import refused

drive = cache(with_truth)
PLANTED = {
    "gyroscope.bias": [1e-3, -2e-3, 5e-4],
    "gyroscope.scale": [0.0, 0.0, 0.02],
    "accelerometer.bias": [0.05, -0.03, 0.02],
    "mounting.lever_arm": [1.0, 0.5, -0.3],
    "mounting.angle": [0.01, -0.01, 0.02],
    "aid.scale": [0.08],
    "aid.time_offset": [0.4],
}


def planted(name: str) -> AttitudeLog:
    log, effect, c = drive(), NAMED[name], np.array(PLANTED[name])
    assert log.airspeed is not None
    if name == "aid.scale":
        return replace(log, airspeed=log.airspeed / (1 + c[0]))
    if name == "aid.time_offset":
        return replace(log, airspeed=np.interp(log.t - c[0], log.t, log.airspeed))
    motion = AttitudeMotion.of(log, log.airspeed)

    def added(columns: FloatArray | None) -> FloatArray | float:
        return 0.0 if columns is None else columns @ c

    rate = log.omega_b + added(effect.rate and effect.rate(motion))
    return replace(log, omega_b=rate, f_b=log.f_b + added(effect.force and effect.force(motion)))


@pytest.mark.parametrize("name", PLANTED)
def test_what_is_planted_is_found_and_taken_off(name: str) -> None:
    found = diagnose_attitude(planted(name), "airspeed-filter", None, G)
    assert [each.effect for each in found.findings] == [name]
    (each,) = found.findings
    assert np.all(np.abs(each.value - PLANTED[name]) < 4.5 * each.std)
    assert found.verdict == "established"
    assert 0.02 < each.share <= 1
    (error,) = found.errors
    assert error.after < error.before
    assert error.held_out_after is not None
    assert error.held_out_after < 0.06  # deg, that of the clean drive


@pytest.mark.parametrize("aid", ["airspeed-filter", "gnss"])
def test_a_clean_drive_is_consistent(aid: str) -> None:
    found = diagnose_attitude(drive(), aid, None, G)
    assert found.verdict == "consistent"
    assert found.findings == ()
    assert len(found.probabilities) >= 5


def test_a_filter_without_speed_lacks_it_and_its_rate() -> None:
    found = diagnose_attitude(drive(), "none", None, G)
    assert [each.effect for each in found.findings] == ["velocity.forward", "velocity.rate"]
    assert [each.value[0] for each in found.findings] == pytest.approx([1, 1], abs=0.02)
    assert min(each.share for each in found.findings) > 0.9
    (error,) = found.errors
    assert error.held_out_before is not None
    assert error.held_out_after is not None
    assert error.held_out_after < 0.01 * error.held_out_before


def test_without_truth_gyros_and_accelerometers_show_the_bias_between_them() -> None:
    log = replace(planted("gyroscope.bias"), roll=None, pitch=None)
    found = diagnose_attitude(log, "airspeed-filter", None, G)
    assert [each.effect for each in found.findings] == ["gyroscope.bias"]
    assert np.all(np.abs(found.findings[0].value - PLANTED["gyroscope.bias"]) < 4.5 * found.findings[0].std)
    (error,) = found.errors
    assert error.held_out_after is not None
    assert error.held_out_before is not None
    assert error.held_out_after < 0.6 * error.held_out_before


def test_a_short_log_is_refused() -> None:
    log = drive()
    few = slice(0, 2000)
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE, "30 s"):
        diagnose_attitude(AttitudeLog(log.t[few], log.omega_b[few], log.f_b[few]), "none", None, G)

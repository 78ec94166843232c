"""An effect/1 of a calibration corrected in samples: its lag of the temperature goes on from block to block."""

import hashlib
from typing import Any

import numpy as np
import pytest

from procedures.effects.temperature_history import lagged
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Surroundings, TemperatureFollower
from station.errors import DataRefused
from tests.refusals import refused

EFFECT = """format = "effect/1"
name = "behind"
triad = "accelerometer"
term = "TERM"
unit = "ug/K"
plausible = 100
source = "IEEE 1293"
shape.tau = {unit = "min", low = 1, high = 60}
"""
TAU_S = 300.0


def calibration(term: str) -> dict[str, Any]:
    text = EFFECT.replace("TERM", term)
    entry = {
        "name": "accelerometer.behind", "definition": text,
        "sha256": hashlib.sha256(text.encode()).hexdigest(),
        "coefficients": {
            **{axis: {"value": value, "std": 1.0} for axis, value in zip("xyz", (50.0, -20.0, 10.0), strict=True)},
            "tau": {"value": TAU_S / 60, "std": 0.1},
        },
    }  # fmt: skip
    triad = {"scale_factor": {"value": [1000.0] * 3}, "misalignment": {"value": np.eye(3).tolist()},
             "bias": {"value": [0.0] * 3}}  # fmt: skip
    return {"accelerometer": triad, "effects": [entry]}


@pytest.mark.parametrize("block", [600, 7])
def test_the_lag_goes_on_from_block_to_block(block: int) -> None:
    t = np.arange(600.0) + 1000.0
    T = 25 + 10 * np.sin(t / 200)
    known = calibration("lag(T, tau)")
    follower, parts = TemperatureFollower((TAU_S,)), list[np.ndarray]()
    for begin in range(0, len(t), block):
        here = slice(begin, begin + block)
        around = Surroundings(t=t[here], signals=follower.take(t[here], T[here]))
        found = calibrated_inputs(known, np.zeros((len(t[here]), 3)), None, around)
        assert found.not_applied == ()
        assert found.f is not None
        parts.append(found.f)
    behind = lagged(t, T, TAU_S) - 25
    expected = -1e-6 * behind[:, None] * [50.0, -20.0, 10.0]
    assert np.abs(np.vstack(parts) - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_parameter_without_a_value_is_refused() -> None:
    known = calibration("lag(T, tau)")
    del known["effects"][0]["coefficients"]["tau"]  # it was not finite
    with refused(DataRefused, None, "accelerometer.behind", "tau"):
        calibrated_inputs(
            known, np.zeros((3, 3)), None, Surroundings(temperature=np.full(3, 30.0), t=np.arange(3.0))
        )


@pytest.mark.parametrize("term", ["smooth(T, tau)", "T * exp(-t / tau)", "lag(T * sign(u), tau)"])
def test_what_one_sample_does_not_determine_is_not_corrected_and_reported(term: str) -> None:
    around = Surroundings(temperature=np.full(3, 30.0), t=np.arange(3.0))
    found = calibrated_inputs(calibration(term), np.zeros((3, 3)), None, around)
    assert [each.partition(":")[0] for each in found.not_applied] == ["accelerometer.behind"]
    assert found.f is not None
    assert not found.f.any()


def test_a_channel_has_its_own_name_and_a_term_has_it_with_aux() -> None:
    text = EFFECT.replace("TERM", "aux_supply").replace("ug/K", "ug/unit").replace(EFFECT.splitlines()[-1], "")
    known = calibration("T")
    known["effects"][0] |= {"definition": text, "sha256": hashlib.sha256(text.encode()).hexdigest()}
    del known["effects"][0]["coefficients"]["tau"]
    supply = np.array([1.0, 2.0, -3.0])
    found = calibrated_inputs(
        known, np.zeros((3, 3)), None, Surroundings(auxiliary={"supply": supply}, t=np.arange(3.0))
    )
    assert found.not_applied == ()
    assert found.f == pytest.approx(-1e-6 * supply[:, None] * [50.0, -20.0, 10.0], abs=1e-15)
    without = calibrated_inputs(known, np.zeros((3, 3)), None, Surroundings())
    assert [each.partition(":")[0] for each in without.not_applied] == ["accelerometer.behind"]

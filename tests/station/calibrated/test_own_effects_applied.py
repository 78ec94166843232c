"""An effect/1 of a calibration taken off samples: its lag of the temperature goes on from block to block."""

import hashlib
from typing import Any

import numpy as np
import pytest

from procedures.effects.temperature_history import lagged
from station.calibrated.calibration_applied import Surroundings, calibrated_inputs
from station.calibrated.temperature_memory import TemperatureMemory
from station.errors import DataRefused

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
        "name": "accelerometer.behind", "unit": "ug/K", "definition": text,
        "sha256": hashlib.sha256(text.encode()).hexdigest(),
        "coefficients": {
            **{axis: {"value": value, "std": 1.0} for axis, value in zip("xyz", (50.0, -20.0, 10.0), strict=True)},
            "tau": {"value": TAU_S / 60, "std": 0.1},
        },
    }  # fmt: skip
    triad = {"scale_factor": {"value": [1000.0] * 3}, "misalignment": {"value": np.eye(3).tolist()},
             "bias": {"value": [0.0] * 3}}  # fmt: skip
    return {"accelerometer": triad, "effects": [entry]}


@pytest.mark.parametrize("block", [600, 50, 7])
def test_the_lag_goes_on_from_block_to_block(block: int) -> None:
    t = np.arange(600.0) + 1000.0
    T = 25 + 10 * np.sin(t / 200)
    known = calibration("lag(T, tau)")
    memory, parts = TemperatureMemory(known), list[np.ndarray]()
    for begin in range(0, len(t), block):
        here = slice(begin, begin + block)
        around = Surroundings(temperature=T[here], t=t[here], followed=dict(memory.followed))
        found = calibrated_inputs(known, np.zeros((len(t[here]), 3)), None, around)
        assert found.not_applied == ()
        assert found.f is not None
        parts.append(found.f)
        for at, value in zip(t[here].tolist(), T[here].tolist(), strict=True):
            memory.advance(at, value)
    behind = lagged(t, T, TAU_S, None) - 25
    expected = -1e-6 * behind[:, None] * [50.0, -20.0, 10.0]
    assert np.abs(np.vstack(parts) - expected).max() < 0.005 * np.abs(expected).max()


def test_a_parameter_without_a_value_is_refused() -> None:
    known = calibration("lag(T, tau)")
    del known["effects"][0]["coefficients"]["tau"]  # it was not finite
    said = r"effects\.accelerometer\.behind: found no value of tau, expected one of every parameter"
    with pytest.raises(DataRefused, match=said):
        TemperatureMemory(known)
    with pytest.raises(DataRefused, match=said):
        calibrated_inputs(
            known, np.zeros((3, 3)), None, Surroundings(temperature=np.full(3, 30.0), t=np.arange(3.0))
        )


@pytest.mark.parametrize("term", ["smooth(T, tau)", "T * exp(-t / tau)", "lag(T * sign(u), tau)"])
def test_what_one_sample_does_not_tell_is_left_in_and_said(term: str) -> None:
    around = Surroundings(temperature=np.full(3, 30.0), t=np.arange(3.0))
    found = calibrated_inputs(calibration(term), np.zeros((3, 3)), None, around)
    assert found.not_applied == (
        "accelerometer.behind: of the campaign, or of what was before; one sample does not tell it",
    )
    assert found.f is not None
    assert not found.f.any()

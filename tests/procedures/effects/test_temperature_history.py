"""The temperature that a sensor follows: one lag or two, from the equilibrium before the campaign."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.effects.temperature_history import sensor_temperature
from tests.procedures.effects.test_jump import rests

WARM_UP_K, WARM_UP_S, TAU, STEP = 8.0, 900.0, 400.0, 0.5


def warmed(t: np.ndarray) -> np.ndarray:
    return 20.0 + WARM_UP_K * (1 - np.exp(-t / WARM_UP_S))


@pytest.mark.parametrize("lags", [1, 2])
def test_lags_of_a_unit_that_was_switched_on_a_minute_before_begin_where_it_did(lags: int) -> None:
    """Against Euler's steps from 20 degC at power-on; by the tangent a minute back it is 0.02 K more."""
    seen = rests(80)
    seen = replace(seen, t=seen.t + 60.0)
    rate = WARM_UP_K / WARM_UP_S * np.exp(-seen.t / WARM_UP_S) * 60
    seen = replace(seen, temperature=warmed(seen.t), temperature_rate=rate)
    grid = np.arange(0.0, seen.t[-1] + STEP, STEP)
    states = np.full((len(grid), 1 + lags), 20.0)
    states[:, 0] = warmed(grid)
    for i in range(1, len(grid)):
        states[i, 1:] = states[i - 1, 1:] + STEP / TAU * (states[i - 1, :-1] - states[i - 1, 1:])
    found = sensor_temperature(seen, TAU, lags=lags) if lags > 1 else sensor_temperature(seen, TAU)
    assert np.max(np.abs(found - np.interp(seen.t, grid, states[:, -1]))) < 0.025

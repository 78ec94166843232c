"""What effects must remember of the temperature: what a sensor lags behind, and which way it went."""

from collections.abc import Mapping
from math import exp, isfinite, nan
from typing import Any

from procedures.effects.effect import TAU
from procedures.effects.temperature_history import REVERSAL_K
from station.calibrated.calibration_applied import own_effect


class TemperatureMemory:
    """The state of lag and hysteresis of a `calibration/1` while samples come in.

    ``followed`` holds by time constant [s] the time [s] and the temperature [degC] that a sensor has come to,
    ``direction`` is 1 while it grows warmer, -1 while it cools, 0 before that is seen.
    """

    def __init__(self, calibration: Mapping[str, Any]) -> None:
        self._taus = [tau for entry in calibration.get("effects", ()) for tau in _lags(entry)]
        self.followed: dict[float, tuple[float, float]] = {}
        self.direction = 0.0
        self._low = self._high = nan

    def advance(self, t: float, temperature: float) -> None:
        """Take in the temperature [degC] that was known until device time ``t`` [s]; going back begins anew."""
        if not isfinite(temperature):
            return
        for tau in self._taus:
            then, before = self.followed.get(tau, (t, temperature))
            left = exp(-(t - then) / tau) if t >= then and tau > 0 else 0.0
            self.followed[tau] = t, temperature + left * (before - temperature)
        self._turn(temperature)

    def _turn(self, temperature: float) -> None:
        self._low = min(temperature, self._low) if isfinite(self._low) else temperature
        self._high = max(temperature, self._high) if isfinite(self._high) else temperature
        if self.direction <= 0 and temperature - self._low > REVERSAL_K:
            self.direction = 1.0
        elif self.direction >= 0 and self._high - temperature > REVERSAL_K:
            self.direction = -1.0
        else:
            return
        self._low = self._high = temperature


def _lags(entry: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the time constants [s] by which an effect follows the temperature."""
    values = {name: float(one["value"]) for name, one in entry.get("coefficients", {}).items()}
    if "definition" not in entry:
        return (values[TAU],) if TAU in values else ()
    term = own_effect(entry).term
    return term.temperature_lags({name: values[name] for name in term.parameters})

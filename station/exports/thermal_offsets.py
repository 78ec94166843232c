"""What a flight stack can take of the temperature: a cubic of each sensor's offset, between two temperatures.

The raw reading at zero input is ``gain (D + b(T))``, b all that goes with the temperature as a polynomial. What
lags behind the thermometer is taken as if it did not. A polynomial above the third order is fitted again by one of
the third, at Chebyshev's nodes, which is within a few per cent of the least that its largest error can be.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from procedures.arrays import FloatArray
from procedures.effects.effect import REFERENCE_C
from procedures.units import S_PER_MIN
from station.calibrated.compiled_effects import POLYNOMIALS
from station.calibrated.temperature_signals import WARMTH
from station.exports.carried_effects import CarriedEffect

ORDER = 3
NODES = 200


@dataclass(frozen=True, slots=True, eq=False)
class ThermalOffset:
    """A triad's offset by temperature: ``cubic`` (3, 4), rows sensors, of powers of T - 25 degC in SI per K^n.

    It is added to the offset at 25 degC, between ``low`` and ``high`` [degC]. ``refit`` is the largest error that
    the third order makes, ``behind`` that of what lags, at 1 K/min, both SI.
    """

    cubic: FloatArray
    low: float
    high: float
    refit: float
    behind: float

    def at(self, temperature: float) -> FloatArray:
        """Return what it adds (3,) [m/s2], [rad/s] at a temperature [degC]."""
        found: FloatArray = self.cubic @ (temperature - REFERENCE_C) ** np.arange(ORDER + 1)
        return found

    def about(self, reference: float) -> FloatArray:
        """Return its coefficients (3, 4) in SI per K^n of powers of T - ``reference`` [degC]."""
        shift = Polynomial([reference - REFERENCE_C, 1.0])
        return _table([Polynomial(row)(shift) for row in self.cubic])


def is_thermal(effect: CarriedEffect) -> bool:
    """Say whether an effect is one of the offset that goes with the temperature, or lags behind it."""
    known = POLYNOMIALS.get(effect.name)
    return known is not None and known.part == "bias" and known.signal in {WARMTH, ""}


def thermal_offset(
    effects: Sequence[CarriedEffect], triad: str, gain: FloatArray, si: float, limits: tuple[float, float]
) -> ThermalOffset | None:
    """Return a triad's offset by temperature, None where it has none.

    ``gain`` (3,) is that of the raw reading, ``si`` what one of the effects' unit is in SI, ``limits`` [degC] are
    the temperatures at which it was measured.
    """
    own = [one for one in effects if one.triad == triad and is_thermal(one)]
    low, high = limits
    if not own or not low < high:
        return None
    most = max(one.coefficients.shape[1] for one in own)
    whole = np.zeros((3, max(most, ORDER) + 1))
    behind = np.zeros(3)
    warmth = (low + high) / 2 - REFERENCE_C + (high - low) / 2 * np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    for one in own:
        whole[:, 1 : one.coefficients.shape[1] + 1] += one.coefficients
        slopes = [np.abs(Polynomial([0.0, *row]).deriv()(warmth)).max() for row in one.coefficients]
        behind += np.array(slopes) * sum(one.lags) / S_PER_MIN
    cubic, refit = whole[:, : ORDER + 1], np.zeros(3)
    if most > ORDER:
        fits = [np.polynomial.Chebyshev.fit(warmth, Polynomial(row)(warmth), ORDER) for row in whole]
        cubic = _table([fit.convert(kind=Polynomial) for fit in fits])
        refit = np.array(
            [np.abs(fit(warmth) - Polynomial(row)(warmth)).max() for fit, row in zip(fits, whole, strict=True)]
        )
    scale = gain * si
    return ThermalOffset(
        cubic * scale[:, None], low, high, float((refit * abs(scale)).max()), float((behind * abs(scale)).max())
    )


def _table(cubics: Sequence[Polynomial]) -> FloatArray:
    """Return the coefficients (3, 4) of polynomials, which leave out those that are nought at their end."""
    return np.array([np.pad(one.coef, (0, ORDER + 1 - len(one.coef))) for one in cubics], dtype=np.float64)

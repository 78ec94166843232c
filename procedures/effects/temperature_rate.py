"""Shupe effect of the gyroscopes: ``c dT/dt``, bias while the coil's temperature changes.

With one single exponential T and dT/dt are one. Plausible: 3 deg/h/(K/min), of a coil wound quadrupolar
and not potted.
"""

from procedures.effects.effect import Columns, Effect, Excitation, per_axis
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S


def columns(excitation: Excitation) -> list[Columns]:
    """Return the rate of temperature per sensor [deg/s per deg/h/(K/min)]."""
    return [Columns(AXES, gyro=per_axis(excitation.temperature_rate / DEG_H_PER_DEG_S))]


EFFECT = Effect(
    name="gyroscope.temperature_rate",
    unit="deg/h/(K/min)",
    physics="c dT/dt",
    source="D. M. Shupe, Thermally induced nonreciprocity, Appl. Opt. 19 (1980) 654",
    plausible=3.0,
    columns=columns,
    separate_by="a heating run with ramps of different steepness, up and down, to the same temperature",
)

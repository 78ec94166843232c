"""Shupe effect of the gyroscopes: ``c dT/dt``, bias while the coil's temperature changes.

With one single exponential T and dT/dt are one. Plausible: 3 deg/h/(K/min), of a coil wound quadrupolar
and not potted.
"""

from procedures.effects.effect import Effect, of_gyroscopes
from procedures.units import DEG_H_PER_DEG_S

EFFECT = Effect(
    name="gyroscope.temperature_rate",
    unit="deg/h/(K/min)",
    physics="c dT/dt",
    source="D. M. Shupe, Thermally induced nonreciprocity, Appl. Opt. 19 (1980) 654",
    plausible=3.0,
    columns=of_gyroscopes(lambda seen: seen.temperature_rate / DEG_H_PER_DEG_S),
    separate_by="a heating run with ramps of different steepness, up and down, to the same temperature",
)

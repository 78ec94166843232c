"""Bias while temperature changes: ``c dT/dt``; of a FOG's coil the Shupe effect.

With one single exponential T and dT/dt are one. Plausible: 3 deg/h/(K/min), of a coil wound quadrupolar and not
potted; 20 ug/(K/min), of a proof mass' suspension between plates of two temperatures.
"""

from dataclasses import replace

from procedures.effects.effect import Effect, of_accelerometers, of_gyroscopes
from procedures.units import DEG_H_PER_DEG_S

GYROSCOPE = Effect(
    name="gyroscope.temperature_rate",
    unit="deg/h/(K/min)",
    physics="c dT/dt",
    source="D. M. Shupe, Thermally induced nonreciprocity, Appl. Opt. 19 (1980) 654",
    plausible=3.0,
    columns=of_gyroscopes(lambda seen: seen.temperature_rate / DEG_H_PER_DEG_S),
    separate_by="a heating run with ramps of different steepness, up and down, to the same temperature",
    driver="temperature",
)
ACCELEROMETER = replace(
    GYROSCOPE,
    name="accelerometer.temperature_rate",
    unit="g/(K/min)",
    source="IEEE Std 1293, temperature-rate sensitivity of bias",
    plausible=2e-5,
    columns=of_accelerometers(lambda seen: seen.temperature_rate),
)

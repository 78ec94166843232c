"""The catalogue of effects: a file for each family of physical causes, a line for each. Its order decides ties.

An `Excitation` (what the sensors went through) goes into an `Effect`, `Columns` (what it may have added) come out.
Where an effect has a `Law` (`term.law`), its equation, all of its users are made from that.
"""

from collections.abc import Mapping

from procedures.effects import (
    bias_noise,
    cube_faces,
    input_nonlinearity,
    jump,
    placement,
    sagnac_sine,
    sensitivities,
    settling,
    site_and_clock,
    surface_plate,
    temperature,
)
from procedures.effects.effect import Effect
from procedures.frames import TRIADS

EFFECTS: tuple[Effect, ...] = (
    input_nonlinearity.QUADRATIC,
    input_nonlinearity.CUBIC,
    input_nonlinearity.ACCELEROMETER_ASYMMETRY,
    input_nonlinearity.CROSS_PRODUCT,
    temperature.ACCELEROMETER_BIAS,
    temperature.ACCELEROMETER_SCALE,
    temperature.ACCELEROMETER_RATE,
    settling.ACCELEROMETER_DRIFT,
    settling.ACCELEROMETER_BIAS,
    settling.ACCELEROMETER_CYCLE,
    temperature.ACCELEROMETER_RATE_LAG,
    temperature.ACCELEROMETER_BIAS_LAG,
    temperature.ACCELEROMETER_SCALE_LAG,
    settling.ACCELEROMETER_SCALE,
    temperature.ACCELEROMETER_HYSTERESIS,
    settling.RELAXATION,
    jump.ACCELEROMETER_JUMP,
    jump.ACCELEROMETER_TURN_ON,
    bias_noise.ACCELEROMETER_INSTABILITY,
    bias_noise.ACCELEROMETER_WALK,
    sensitivities.ACCELEROMETER_VIBRATION,
    sensitivities.G_SENSITIVITY,
    temperature.GYROSCOPE_BIAS,
    temperature.GYROSCOPE_SCALE,
    temperature.GYROSCOPE_RATE,
    settling.GYROSCOPE_DRIFT,
    settling.GYROSCOPE_BIAS,
    settling.GYROSCOPE_CYCLE,
    temperature.GYROSCOPE_RATE_LAG,
    temperature.GYROSCOPE_BIAS_LAG,
    temperature.GYROSCOPE_SCALE_LAG,
    settling.GYROSCOPE_SCALE,
    temperature.GYROSCOPE_HYSTERESIS,
    sensitivities.MAGNETIC,
    input_nonlinearity.GYROSCOPE_ASYMMETRY,
    input_nonlinearity.SCALE_NONLINEARITY,
    sagnac_sine.EFFECT,
    input_nonlinearity.COUNTS_LOST,
    jump.GYROSCOPE_JUMP,
    jump.GYROSCOPE_TURN_ON,
    bias_noise.GYROSCOPE_INSTABILITY,
    bias_noise.GYROSCOPE_WALK,
    sensitivities.GYROSCOPE_VIBRATION,
    surface_plate.TILT,
    cube_faces.FACE_TILT,
    cube_faces.PARALLELISM,
    placement.DWELL,
    placement.LABEL,
    placement.SCATTER,
    jump.UNIT_TILT,
    surface_plate.CLOSURE,
    surface_plate.HEADING,
    site_and_clock.AZIMUTH,
    site_and_clock.GRAVITY,
    site_and_clock.LATITUDE,
    site_and_clock.CLOCK_RATE,
    placement.DISTURBANCE,
    sensitivities.CHANNEL,
)
CATALOGUE: Mapping[str, Effect] = {effect.name: effect for effect in EFFECTS}


def _meaning(effect: Effect) -> str:
    triad = effect.name.partition(".")[0]
    return effect.meaning if triad not in TRIADS or triad in effect.meaning else f"{effect.meaning}, {triad}"


MEANINGS: Mapping[str, str] = {effect.name: _meaning(effect) for effect in EFFECTS}
"""What each effect of the catalogue is, in words."""

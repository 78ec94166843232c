"""The catalogue of effects: a file for each physical cause, a line for each effect. Its order decides ties."""

from collections.abc import Iterator, Mapping
from importlib import import_module
from types import ModuleType

from procedures.effects import (
    auxiliary_channel,
    bias_drift,
    bias_settling,
    bias_temperature,
    clock_rate,
    closure,
    counts_lost,
    cross_product,
    cubic,
    disturbance_dwell,
    face_tilt,
    g_sensitivity,
    heading,
    jump,
    magnetic,
    parallelism,
    placement_dwell,
    placement_label,
    placement_scatter,
    quadratic,
    relaxation,
    sagnac_sine,
    scale_asymmetry,
    scale_nonlinearity,
    scale_settling,
    scale_temperature,
    scale_temperature_lag,
    site_azimuth,
    site_gravity,
    site_latitude,
    slab_tilt,
    temperature_hysteresis,
    temperature_lag,
    temperature_rate,
    turn_on_bias,
    unit_tilt,
    vibration_rectification,
)
from procedures.effects.effect import Effect
from procedures.frames import TRIADS

EFFECTS: tuple[Effect, ...] = (
    quadratic.EFFECT,
    cubic.EFFECT,
    scale_asymmetry.ACCELEROMETER,
    cross_product.EFFECT,
    bias_temperature.ACCELEROMETER,
    scale_temperature.ACCELEROMETER,
    temperature_rate.ACCELEROMETER,
    bias_drift.ACCELEROMETER,
    bias_settling.ACCELEROMETER,
    temperature_lag.ACCELEROMETER,
    scale_temperature_lag.ACCELEROMETER,
    scale_settling.ACCELEROMETER,
    temperature_hysteresis.ACCELEROMETER,
    relaxation.EFFECT,
    jump.ACCELEROMETER,
    turn_on_bias.ACCELEROMETER,
    vibration_rectification.ACCELEROMETER,
    g_sensitivity.EFFECT,
    bias_temperature.GYROSCOPE,
    scale_temperature.GYROSCOPE,
    temperature_rate.GYROSCOPE,
    bias_drift.GYROSCOPE,
    bias_settling.GYROSCOPE,
    temperature_lag.GYROSCOPE,
    scale_temperature_lag.GYROSCOPE,
    scale_settling.GYROSCOPE,
    temperature_hysteresis.GYROSCOPE,
    magnetic.EFFECT,
    scale_asymmetry.GYROSCOPE,
    scale_nonlinearity.EFFECT,
    sagnac_sine.EFFECT,
    counts_lost.EFFECT,
    jump.GYROSCOPE,
    turn_on_bias.GYROSCOPE,
    vibration_rectification.GYROSCOPE,
    slab_tilt.EFFECT,
    face_tilt.EFFECT,
    parallelism.EFFECT,
    placement_dwell.EFFECT,
    placement_label.EFFECT,
    placement_scatter.EFFECT,
    unit_tilt.EFFECT,
    closure.EFFECT,
    heading.EFFECT,
    site_azimuth.EFFECT,
    site_gravity.EFFECT,
    site_latitude.EFFECT,
    clock_rate.EFFECT,
    disturbance_dwell.EFFECT,
    auxiliary_channel.EFFECT,
)


def _meanings() -> Iterator[tuple[str, str]]:
    """Yield by name what an effect is in words: the first phrase of its file."""
    package = import_module(__name__)
    for module in vars(package).values():
        if isinstance(module, ModuleType) and module.__name__.startswith(f"{__name__}."):
            phrase = (module.__doc__ or "").partition("\n")[0].partition(":")[0].rstrip(".")
            for effect in vars(module).values():
                if isinstance(effect, Effect):
                    triad = effect.name.partition(".")[0]
                    is_told = triad not in TRIADS or triad in phrase
                    yield effect.name, phrase if is_told else f"{phrase}, {triad}"


MEANINGS: Mapping[str, str] = dict(_meanings())
"""What each effect of the catalogue is, in words."""

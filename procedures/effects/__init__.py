"""The catalogue: one physical cause a file, one line each. Its order decides ties."""

from procedures.effects import accelerometer_bias_temperature, g_sensitivity, quadratic
from procedures.effects.effect import Effect

EFFECTS: tuple[Effect, ...] = (
    quadratic.EFFECT,
    accelerometer_bias_temperature.EFFECT,
    g_sensitivity.EFFECT,
)

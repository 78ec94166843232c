"""The demo's unit: random, and with an error that nobody declared."""

from dataclasses import replace

from drivers.simulated.truth import Truth

EFFECT, AXIS = "accelerometer.bias_temperature", "z"
COEFFICIENT = 4e-6  # g/K: less than the seating check takes for debris below the cube in this warming
RISE_K, TAU_S = 6.0, 400.0  # as after switching on


def demo_truth(seed: int) -> Truth:
    """Return a random unit that warms up, and the bias of whose accelerometer z follows the temperature."""
    planted = {EFFECT: {AXIS: COEFFICIENT}}
    return replace(Truth.example(seed), effects=planted, temperature_rise_k=RISE_K, temperature_tau_s=TAU_S)

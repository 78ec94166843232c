"""The demo's unit: random, and with an error that nobody declared."""

from dataclasses import replace

from drivers.simulated.truth import Truth

EFFECT, KEY = "gyroscope.magnetic", "zz"  # the Faraday effect in a coil that is not well shielded
COEFFICIENT = 0.02  # deg/h/uT


def demo_truth(seed: int) -> Truth:
    """Return a random unit whose gyroscope z also measures the magnetic field along its axis."""
    return replace(Truth.example(seed), effects={EFFECT: {KEY: COEFFICIENT}})

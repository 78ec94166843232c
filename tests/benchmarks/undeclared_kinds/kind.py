"""What a kind of undeclared effect is: what it adds, in which campaign, and the name that is right."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Truth

GRID_S = 0.5  # of temperature's own history
LONGEST_S = 8000.0


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """What is drawn of one campaign's effect: ``along`` (3,) signs and shares of the sensors, and numbers."""

    rng: np.random.Generator
    truth: Truth
    along: np.ndarray

    def number(self, low: float, high: float) -> float:
        """Draw evenly between two numbers, each as likely in its logarithm."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def phases(self) -> np.ndarray:
        """Draw a phase (3,) [rad] of each sensor."""
        return self.rng.uniform(0, 2 * np.pi, 3)

    def temperature(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and temperatures [degC] since power-on."""
        t, truth = np.arange(0.0, LONGEST_S, GRID_S), self.truth
        warm = truth.temperature_rise_k * -np.expm1(-t / truth.temperature_tau_s)
        swing = truth.temperature_swing_k * np.sin(2 * np.pi * t / truth.temperature_swing_period_s)
        return t, truth.temperature_start_c + warm + swing


Add = Callable[[Stimulus, TriadInput, float], np.ndarray]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind: ``triad`` gyro or accel, ``made`` of what is drawn, ``right`` names (none: in no catalogue).

    ``least`` and ``most`` bound its size [g or deg/s, or a share]; ``block_s`` is how finely its size is measured;
    ``of_bench`` are names that are true of how its campaigns are made.
    """

    name: str
    triad: str
    made: Callable[[Drawn], Add]
    design: str = "plain"
    right: tuple[str, ...] = ()
    least: float = 1e-9
    most: float = 1e-2
    block_s: float = 2.0
    of_bench: tuple[str, ...] = ()

    def planted(self, seed: int, truth: Truth, size: float) -> Planted:
        """Return it with a size, and no memory of an earlier campaign."""
        rng = np.random.default_rng([seed, 41])
        along = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.0, 3)
        if rng.random() < 0.5:  # one sensor alone
            along *= np.arange(3) == rng.integers(3)
        add = self.made(Drawn(rng, truth, along))

        def added(seen: Stimulus, triad: TriadInput, sizes: object) -> np.ndarray:
            return add(seen, triad, size)

        one = {self.triad: added}
        return ((PlantedEffect(self.name, "", (), accel=one.get("accel"), gyro=one.get("gyro")), {}),)

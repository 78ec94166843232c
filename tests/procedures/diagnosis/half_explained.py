"""A cause of the catalogue next to one of none: temperature, and a pressure that nobody records."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.effects import Planted, PlantedEffect, Stimulus, TriadInput
from procedures.campaign.campaign import Campaign
from procedures.frames import AXES
from procedures.inference.result import Diagnosis
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import GivenValues, Unexplained
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of


@dataclass(frozen=True, slots=True, eq=False)
class HalfExplained:
    """Campaigns, the accelerometers' true bias (3,) [g] at 25 degC, and what the pressure does at most [g]."""

    campaigns: tuple[Campaign, ...]
    bias_g: np.ndarray
    size_g: float


def half_explained(seed: int, size_g: float | None = None) -> HalfExplained:
    """Return twelve positions while it warms: 2 to 4 ug/K, and 3 to 6 ug of pressure, or ``size_g``."""
    rng, truth = np.random.default_rng([seed, 5]), truth_of("warm", seed)
    c = rng.choice([-1, 1], 3) * rng.uniform(2e-6, 4e-6, 3)
    truth = replace(truth, effects={"accelerometer.bias_temperature": dict(zip("xyz", c.tolist(), strict=True))})
    drawn = float(rng.uniform(3e-6, 6e-6))
    size = drawn if size_g is None else size_g
    made = campaigns_of(truth, "warm", seed, pressure(seed, size))
    on = truth.powered_on(np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[1]))
    return HalfExplained(made.campaigns, np.asarray(on.accel_d_g), size)


def pressure(seed: int, size_g: float) -> Planted:
    """Return a bias of the accelerometers by a pressure that cycles, in one sensor or in all."""
    rng = np.random.default_rng([seed, 41])
    along = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.5, 1.0, 3)
    if rng.random() < 0.5:  # one sensor alone
        along *= np.arange(3) == rng.integers(3)
    period, phase = float(np.exp(rng.uniform(np.log(300), np.log(700)))), rng.uniform(0, 6.28)

    def added(seen: Stimulus, triad: TriadInput, sizes: object) -> np.ndarray:
        return np.asarray(along * size_g * np.sin(2 * np.pi * seen.t / period + phase))

    return ((PlantedEffect("pressure", "", (), accel=added), {}),)


def expanded_bias(found: Diagnosis, unexplained: Mapping[str, Unexplained] | None) -> np.ndarray:
    """Return U (3,) [g] of the accelerometers' bias with the effects in."""
    given = {each.name: each.expanded for each in budget(found.after, GivenValues(unexplained=unexplained))}
    return np.array([given[f"accelerometer.bias.{axis}"] for axis in AXES])


def by_residual(found: Diagnosis) -> dict[str, Unexplained]:
    """Return what a diagnosis leaves, without what effects took of it."""
    return {triad: replace(left, moved=None) for triad, left in (found.unexplained or {}).items()}

"""A cause of the catalogue beside one of none: temperature, and a pressure that nobody records."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.result import Diagnosis
from procedures.frames import AXES
from procedures.uncertainty.budget import budget
from procedures.uncertainty.given_values import GivenValues, Unexplained
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.catalogue import KINDS


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
    made = campaigns_of(truth, "warm", seed, KINDS["pressure cycles"].planted(seed, truth, size))
    on = truth.powered_on(np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[1]))
    return HalfExplained(made.campaigns, np.asarray(on.accel_d_g), size)


def expanded_bias(found: Diagnosis, unexplained: Mapping[str, Unexplained] | None) -> np.ndarray:
    """Return U (3,) [g] of the accelerometers' bias with the effects in."""
    given = {each.name: each.expanded for each in budget(found.after, GivenValues(unexplained=unexplained))}
    return np.array([given[f"accelerometer.bias.{axis}"] for axis in AXES])


def by_residual(found: Diagnosis) -> dict[str, Unexplained]:
    """Return what a diagnosis leaves, without what effects took of it."""
    return {triad: replace(left, moved=None) for triad, left in (found.unexplained or {}).items()}

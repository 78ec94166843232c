"""How far a finding's coefficients are from what was planted, in their own sigma."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from drivers.simulated.bench_in_memory import SETTLING_S
from drivers.simulated.truth import Truth
from procedures.evidence.linear_model import Term
from procedures.frames import AXES
from procedures.positions import FACES, cross_axes
from tests.benchmarks.diagnosing.plants import Sizes
from tests.benchmarks.diagnosing.sigmas import catalogued

NOTHING = 1e-12


@dataclass(frozen=True)
class Cause:
    """A name with its probability, the group it cannot be separated from, its columns and coefficients."""

    effect: str
    probability: float
    group: tuple[str, ...] = ()
    group_probability: float = 0.0
    terms: tuple[Term, ...] = ()
    coefficients: tuple[str, ...] = ()
    value: np.ndarray = field(default_factory=lambda: np.zeros(0))
    std: np.ndarray = field(default_factory=lambda: np.zeros(0))
    unit: str = ""
    where: Mapping[str, object] = field(default_factory=dict)
    shape: str = ""


def errors_of(finding: Cause, sizes: Sizes, truth: Truth) -> np.ndarray:
    """Return the error (k,) of every coefficient over its sigma, infinite where it is about something else.

    nan where planter and catalogue speak of two things: a cubic where ``u |u|`` was planted.
    """
    about_other = finding.effect in {"placement.label", "disturbance.dwell"} and (
        first_of(finding) != sizes["position"]
    )
    in_proportion = finding.effect in {"disturbance.dwell", "accelerometer.relaxation"} and finding.unit != "g"
    if finding.shape == "u^3":
        return np.full(len(finding.coefficients), np.nan)
    if about_other or in_proportion:
        return np.full(len(finding.coefficients), np.inf)
    expected = np.array([_expected(finding, sizes, truth, key) for key in finding.coefficients])
    return (finding.value - expected) / np.maximum(finding.std, NOTHING)


def _expected(finding: Cause, sizes: Sizes, truth: Truth, key: str) -> float:
    """Return what a coefficient should be: as planted, in the finding's words."""
    effect = finding.effect
    if effect == "accelerometer.cross_product":
        return {catalogued(k): size for k, size in sizes.items()}.get(key, 0.0)
    if effect == "accelerometer.relaxation":  # planted from the flip on, found from where the step begins
        return sizes.get(key, 0.0) * float(np.exp(-SETTLING_S / sizes["tau_s"]))
    if effect == "slab.tilt":
        return float(truth.slab_tilt_rad["east north".split().index(key)]) + sizes.get(key, 0.0)
    if effect == "fixture.parallelism":
        axis, across = key.split(".")
        pair, column = AXES.index(axis), cross_axes(f"{axis}_up").index(AXES.index(across))
        both = [FACES.index(f"{axis}_{end}") for end in ("up", "down")]
        assert both == [2 * pair, 2 * pair + 1]
        return float(truth.faces_rad[both, column].sum()) + sizes.get(key, 0.0)
    if effect == "placement.dwell" and first_of(finding) != sizes["position"]:
        return -sizes.get(key, 0.0)  # the pair's other position, seen from which it is the other way round
    if effect == "site.gravity" and finding.where.get("campaign") == 1:
        return -sizes.get(key, 0.0)
    return sizes.get(key, 0.0)


def first_of(finding: Cause) -> object:
    """Return the position that a finding's coefficients are about, of two that cannot be told."""
    position = finding.where.get("position")
    return position[0] if isinstance(position, list) else position

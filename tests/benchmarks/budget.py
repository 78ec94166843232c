"""The uncertainty budget next to a Monte Carlo of the whole chain (JCGM 101:2008).

Everything the budget has as uncertain is drawn (counts, headings, closures, gravity, certificates, the cube,
latitude and time base where they are in), integer counts are simulated and solved.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit
from procedures.frames import AXES
from procedures.twelve_positions.bench_parameters import mean_cube
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import EXACT, GivenValues
from tests.proof.evidence import Figure, spread

UNIT = 1
CHUNK = 4
ASKED = 0.05


@dataclass(frozen=True)
class Kind:
    """A kind of campaign: dwells, noise of a sample [g], certificate [rad], what is drawn with them."""

    dwell_s: float = 100.0
    noise_g: float = 1e-5
    certificate: float | None = None
    inputs: GivenValues = EXACT


KINDS = {
    "no certificate": Kind(),
    "faces certified": Kind(certificate=5e-6),
    "short noisy dwells": Kind(dwell_s=20.0, noise_g=3e-4),
    "short dwells, latitude and clock": Kind(
        dwell_s=20.0, noise_g=3e-4, inputs=GivenValues(float(np.radians(0.3)), 1e-5)
    ),
}


def trial(seed: int, kind: str) -> np.ndarray:
    """Return errors, u and U (3, parameters) of one campaign: another cube and another operator's day."""
    how, rng = KINDS[kind], np.random.default_rng([seed, 0xB0D6])
    stated = replace(Truth.example(UNIT), accel_noise_g=how.noise_g, faces_rad=3e-5 * rng.standard_normal((6, 2)))
    latitude, clock = np.array([np.degrees(how.inputs.latitude), how.inputs.clock]) * rng.standard_normal(2)
    true = replace(
        stated,
        latitude_deg=stated.latitude_deg + latitude,
        effects={"clock.rate": {"value": clock * 1e6}} if clock else {},
    )
    campaign = simulate_campaign(true, seed, dwell_s=how.dwell_s, certificate_sigma=how.certificate)
    site = replace(campaign.site, latitude=float(np.radians(stated.latitude_deg)))
    budgets = budget(fit([replace(campaign, site=site)]), how.inputs)
    known = expected(stated, how.certificate is not None)
    return np.array([(one.value - known[one.name], one.std, one.expanded) for one in budgets]).T


def expected(truth: Truth, certified: bool) -> dict[str, float]:
    """Return what each parameter should come out as; without a certificate E refers to the mean cube."""
    faces = truth.faces_rad.reshape(3, 2, 2)
    axes = np.eye(3) if certified else mean_cube((faces[:, 0] - faces[:, 1]) / 2)
    found = dict[str, float]()
    for triad, k, E, D in (
        ("accelerometer", truth.accel_k, truth.accel_e, truth.accel_d_g),
        ("gyroscope", truth.gyro_k, truth.gyro_e, truth.gyro_d_deg_s * 3600),
    ):
        seen = E @ axes
        seen /= np.linalg.norm(seen, axis=1)[:, None]
        for q, sensor in enumerate(AXES):
            found[f"{triad}.scale_factor.{sensor}"] = float(k[q])
            found[f"{triad}.bias.{sensor}"] = float(D[q])
            found |= {f"{triad}.misalignment.{sensor}{body}": float(seen[q, p]) for p, body in enumerate(AXES)}
    return found


@dataclass(frozen=True, eq=False)
class Comparison:
    """Per parameter: the budget's u over the Monte Carlo's std, and the share covered by U."""

    std: np.ndarray
    covered: np.ndarray
    campaigns: int

    @property
    def own_std(self) -> float:
        """1 sigma of ``std`` by sampling: a standard deviation of n draws is known to 1 / sqrt(2 n)."""
        return float(1 / np.sqrt(2 * self.campaigns))


def compare(rows: Sequence[np.ndarray]) -> Comparison:
    """Set the budgets next to the scatter of the errors."""
    error, u, U = np.stack(rows, axis=1)
    std = np.sqrt(np.mean(error**2, axis=0))
    covered = np.mean(np.abs(error) <= U, axis=0)
    return Comparison(u.mean(axis=0) / std, covered, len(rows))


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return, for each kind of campaign, how far the budget is from the scatter, and how often U covers."""
    result = dict[str, Figure]()
    for kind in KINDS:
        found = compare(spread(partial(trial, kind=kind), range(seed, seed + size), CHUNK))
        off = ASKED + 2 * found.own_std
        median = Figure(float(np.median(found.std)), at_least=1 - off, at_most=1 + off)
        result[f"{kind}: u over the scatter, median"] = median
        result[f"{kind}: covered by U"] = Figure(100 * float(found.covered.mean()), "%")
    return result

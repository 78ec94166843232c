"""What the best possible test would see of a scatter: the likelihood ratio with its size known (Neyman, Pearson).

Along each direction that the model leaves, what is left is normal with variance 1 of noise, and 1 + s^2 with a
scatter; s is how many sigmas one unit of it does there. The sum of s^2 / (1 + s^2) z^2 is the most powerful test.
"""

from functools import cache

import numpy as np

from procedures.calibration.joint_calibration import fit
from procedures.diagnosis.candidates import Candidates
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import evidence_of
from procedures.effects import EFFECTS
from tests.benchmarks.diagnosing.designs import DESIGNS, unit

DRAWS = 100_000
FALSE_ALARM = 0.01 / len(EFFECTS)  # of one effect among all that are tried


@cache
def _sigmas(effect: str, design: str, seed: int = 1) -> tuple[float, ...]:
    """Return how many sigmas one unit of a scatter does along each direction that the model leaves."""
    made = DESIGNS[design]
    fits = fit(made.make(unit(seed, **made.truth), seed, ()))
    evidence = evidence_of(fits)
    (way,) = Candidates(evidence, fits, EFFECTS)[effect]
    base = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    W = way.term.H / evidence.sigma[:, None]
    Q = base.Q[: len(W)]
    return tuple(np.linalg.svd(W - Q @ (Q.T @ W), compute_uv=False).tolist())


@cache
def power(effect: str, design: str, size: float, false_alarm: float = FALSE_ALARM) -> float:
    """Return the probability (0 to 1) with which the best test sees a scatter of a ``size`` in its unit."""
    return power_of(size * np.array(_sigmas(effect, design)), false_alarm)


def power_of(sigmas: np.ndarray, false_alarm: float) -> float:
    """Return the same of a scatter that does ``sigmas`` (k,) of noise along each direction."""
    variance = sigmas**2
    z = np.random.default_rng(0).standard_normal((DRAWS, len(variance))) ** 2
    weight = variance / (1 + variance)
    threshold = np.quantile(z @ weight, 1 - false_alarm)
    return float(np.mean((z * (1 + variance)) @ weight > threshold))

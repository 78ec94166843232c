"""A straight line through points whose errors hang together, with a sigma that says so.

The errors are taken to be white noise and an Ornstein-Uhlenbeck process in parts and with a memory that nobody
states: from that of a point to that of the whole span. Each such noise gives a line by generalised least
squares; they are averaged, weighted by their restricted likelihood (Patterson and Thompson 1971), so that what
the points cannot tell of their noise widens the sigma. Errors that walk away without bound are not among them:
no points tell them from a line.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray

MEMORIES = 5  # tried, from the distance of points to their span
PARTS = (0.3, 0.6, 0.9)  # of the variance that remembers
WHITE = 4.0  # times as credible beforehand as any of these: noise without memory
LEAST = 3  # points beyond the coefficients


@dataclass(frozen=True, slots=True)
class CorrelatedLine:
    """A slope, its 1 sigma, and the degrees of freedom behind it."""

    slope: float
    std: float
    dof: float


def fit_correlated_line(
    x: FloatArray, y: FloatArray, group: IntArray, least: float = 0.0
) -> CorrelatedLine | None:
    """Fit ``y`` (n,) over ``x`` (n,), one slope and an offset for each ``group`` (n,); None for too few points.

    ``least`` is the 1 sigma that a point has at the least, in units of y.
    """
    n, span = len(x), float(np.ptp(x))
    _, member = np.unique(group, return_inverse=True)
    design = np.column_stack([np.eye(int(member.max(initial=0)) + 1)[member], (x - x.mean()) / (span or 1.0)])
    dof = n - design.shape[1]
    if dof < LEAST or not span > 0:
        return None
    apart = np.abs(x[:, None] - x) / span
    found = [_fit(np.ones(n), design, y, least)]
    for memory in np.geomspace(1 / n, 1.0, MEMORIES):
        w, V = np.linalg.eigh(np.exp(-apart / memory))
        found += [_fit(1 - part + part * np.maximum(w, 0.0), V.T @ design, V.T @ y, least) for part in PARTS]
    likelihood, slope, variance = np.array(found).T
    weight = np.exp(likelihood - likelihood.max())
    weight[0] *= WHITE
    weight /= weight.sum()
    mean = float(weight @ slope)
    std = float(np.sqrt(weight @ (variance + (slope - mean) ** 2)))
    return CorrelatedLine(mean / span, std / span, float(dof))


def _fit(d: FloatArray, design: FloatArray, y: FloatArray, least: float) -> tuple[float, float, float]:
    """Return the restricted log likelihood, the slope and its variance for errors of covariance diag(d) s^2."""
    n, k = design.shape
    normal = (design.T / d) @ design
    b = np.linalg.solve(normal, (design.T / d) @ y)
    variance = max(float(((y - design @ b) ** 2 / d).sum()) / (n - k), least**2, np.finfo(float).tiny)
    likelihood = -0.5 * (np.log(d).sum() + np.linalg.slogdet(normal)[1] + (n - k) * np.log(variance))
    return float(likelihood), float(b[-1]), variance * float(np.linalg.inv(normal)[-1, -1])

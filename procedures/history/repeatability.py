"""Turn-on repeatability: scatter from one turn-on to the next, beyond the calibrations' own sigmas.

Calibrations within `CLUSTER_DAYS` of a cluster's first one are a cluster: so close that ageing adds nothing, each
with the unit switched on anew. With ``m_c`` the mean of cluster c,

    y_i = m_c + r_i + e_i,    e_i ~ N(0, s_i^2) known,    r_i ~ N(0, tau^2),
    Q(tau^2) = sum_c sum_i w_i (y_i - ybar_c)^2,  w_i = 1 / (s_i^2 + tau^2),  ybar_c weighted with w_i.

At the true tau, Q is chi-squared with n - c degrees of freedom and falls as tau grows. The estimate is where Q is
that number (Mandel and Paule, Anal. Chem. 42, 1194, 1970), the 95 % interval where Q is a 2.5 or 97.5 % quantile
(Viechtbauer, Statist. Med. 26, 37, 2007). The 1 sigma comes from the restricted likelihood's information on tau^2.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from procedures.arrays import FloatArray
from procedures.history.parameter_series import CalibrationSeries

CLUSTER_DAYS = 7.0


@dataclass(frozen=True, slots=True)
class Repeatability:
    """The standard deviation tau from turn-on to turn-on; ``std`` is None where tau is 0: see the interval."""

    value: float
    std: float | None
    low_95: float
    high_95: float
    runs: int
    dof: int


def turn_on_repeatability(series: CalibrationSeries) -> Repeatability | None:
    """Return the repeatability, None where no two calibrations lie within `CLUSTER_DAYS`."""
    together = [(series.value[one], series.std[one]) for one in clusters(series.day) if len(one) > 1]
    runs = sum(len(values) for values, _ in together)
    if (dof := runs - len(together)) == 0:
        return None
    low, high = (_variance(together, float(chi2.ppf(q, dof))) for q in (0.975, 0.025))
    found = _variance(together, float(dof))
    value = float(np.sqrt(found))
    std = float(np.sqrt(2.0 / _information(together, found)) / (2.0 * value)) if value > 0 else None
    return Repeatability(value, std, float(np.sqrt(low)), float(np.sqrt(high)), runs, dof)


def clusters(day: FloatArray) -> list[list[int]]:
    """Return the indices of the calibrations of each cluster; ``day`` (n,) rises."""
    found = list[list[int]]()
    for i, at in enumerate(day):
        if found and at - day[found[-1][0]] <= CLUSTER_DAYS:
            found[-1].append(i)
        else:
            found.append([i])
    return found


def _excess(clusters: list[tuple[FloatArray, FloatArray]], variance: float) -> float:
    total = 0.0
    for value, std in clusters:
        weight = 1.0 / (std**2 + variance)
        total += float(weight @ (value - weight @ value / weight.sum()) ** 2)
    return total


def _variance(clusters: list[tuple[FloatArray, FloatArray]], wanted: float) -> float:
    """Return tau^2 at which Q is ``wanted``, 0 if Q is less even there."""
    if _excess(clusters, 0.0) <= wanted:
        return 0.0
    scatter = sum(float(((value - value.mean()) ** 2).sum()) for value, _ in clusters)
    return float(brentq(lambda v: _excess(clusters, v) - wanted, 0.0, 2.0 * scatter / wanted, rtol=1e-12))


def _information(clusters: list[tuple[FloatArray, FloatArray]], variance: float) -> float:
    """Return tr(P P), twice the information on tau^2; ``P = W - W 1 1' W / (1' W 1)`` cluster by cluster."""
    total = 0.0
    for _, std in clusters:
        weight = 1.0 / (std**2 + variance)
        one, two, three = (float((weight**power).sum()) for power in (1, 2, 3))
        total += two - 2.0 * three / one + (two / one) ** 2
    return total

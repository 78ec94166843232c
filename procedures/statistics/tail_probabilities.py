"""Logarithms of tail probabilities, where the probabilities themselves are too small for a float.

Large effects underflow to p = 0, and of several zeros the first in the alphabet would win.
"""

import numpy as np
from scipy.special import betainc, betaln, gammaincc, gammaln

LEADING_TERMS_BELOW = 1e-200  # below which the leading terms are used
LAST_TERM_NATS = 40  # -ln of the last term of a series
KNOWN_VARIANCE_DOF = 1e6  # degrees of freedom beyond which a variance is known


def log_chi2_sf(chi2: float, k: float) -> float:
    """Return ln P(X > chi2) for chi-square of k degrees of freedom."""
    a, x = k / 2, chi2 / 2
    p = float(gammaincc(a, x))
    if p > LEADING_TERMS_BELOW:
        return float(np.log(p))
    series, term = 1.0, 1.0  # Gamma(a, x) ~ x^(a-1) e^-x (1 + (a-1)/x + ...), Abramowitz and Stegun 6.5.32
    for i in range(1, 8):
        term *= (a - i) / x
        series += term
    return float((a - 1) * np.log(x) - x - gammaln(a) + np.log(series))


def log_f_sf(f: float, k: int, dof: float) -> float:
    """Return ln P(F > f) for k and dof degrees of freedom; chi-square / k where dof is infinite.

    P = I_x(dof/2, k/2) at x = dof / (dof + k f), far out by its hypergeometric series (Abramowitz and Stegun
    26.5.23).
    """
    if dof > KNOWN_VARIANCE_DOF:
        return log_chi2_sf(k * f, k)
    if f <= 0:
        return 0.0
    a, b, x = dof / 2, k / 2, dof / (dof + k * f)
    p = float(betainc(a, b, x))
    if p > LEADING_TERMS_BELOW:
        return float(np.log(p))
    i = np.arange(int(LAST_TERM_NATS / (1 - x)))
    series = 1 + float(np.sum(np.cumprod((a + b + i) / (a + 1 + i) * x)))
    return float(a * np.log(x) + b * np.log1p(-x) - np.log(a) - betaln(a, b) + np.log(series))

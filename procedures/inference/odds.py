"""The odds of what is no row of the evidence: what acts sample by sample, and what went wrong in a recording.

The rule is that of the rows:

    ln posterior odds = ln prior odds - ln N + ln marginal likelihood ratio

N are the frequencies, lags, sensors or stretches among which it was looked for: each has its share of the prior.
The ratio is that of `marginal`. The prior of a coefficient is N(0, s^2), the amplitude s averaged over
`priors.OF_NAMELESS`; at s = 1 all coefficients together are 1 sigma of the data.
"""

from collections.abc import Mapping

import numpy as np
from scipy.special import expit

from procedures.arrays import FloatArray
from procedures.inference import priors
from procedures.inference.marginal import gains_along, log_mean, log_sum


def gain(G: FloatArray, g: FloatArray, dof: float = np.inf) -> float:
    """Return ln of the marginal likelihood of some columns over that of noise alone.

    Parameters
    ----------
    G, g : (k, k), (k,), of whitened columns W and data y: W'W and W'y
    dof : degrees of freedom to which the noise is known
    """
    size, V = np.linalg.eigh(G)
    total = float(np.trace(G))
    acts = size > max(float(size[-1]), 0.0) * len(g) * np.finfo(float).eps
    if not (total > 0 and acts.any()):
        return 0.0
    size, along = size[acts], (V.T @ g)[acts]
    squares = np.sum(along**2 / size)
    scaled = size / total, along / np.sqrt(total)
    return float(log_mean(gains_along(*scaled, priors.OF_NAMELESS, squares, int(acts.sum()), dof)))


def gain_of_squares(squares: FloatArray, number: float, dof: float = np.inf) -> FloatArray:
    """Return the gain (m,) of ``number`` coefficients that are equally well known, by their sum of squares.

    That is ``squares`` (m,) [sigma^2]. A variance is such a sum: what acts makes it larger.
    """
    each = np.array([1 / number])
    along = np.sqrt(np.maximum(squares, 0.0) / number)[..., None]
    return log_mean(gains_along(each, along, priors.OF_NAMELESS, squares, number, dof, number))


def log_odds(gain: float, tried: float = 1.0) -> float:
    """Return ln of the posterior odds of a name by its gain, of ``tried`` that were as likely."""
    return float(np.log(priors.ODDS_NAMED / tried) + gain)


def probability(log_odds: float) -> float:
    """Return the probability at ln odds."""
    return float(expit(log_odds))


def shares(log_odds: Mapping[str, float]) -> dict[str, float]:
    """Return the probabilities of explanations that exclude each other, by ln of their odds over that of none."""
    none = log_sum(np.array([0.0, *log_odds.values()]))
    return {name: min(float(np.exp(each - none)), 1.0) for name, each in log_odds.items()}

"""Rows that contradict the others: the law by which a pose or a rate point is held against the fit to the rest.

A row's error z [sigma] has the marginal likelihood of one coefficient (`procedures.inference.odds`), averaged over
what the rows leave open: how large the noise is, what curve the others follow. With ln of the weight w of each
case, which is its prior and the likelihood of all rows with this one right,

    ln odds = ln prior odds - ln N + ln mean(exp(w + gain(z))) - ln mean(exp(w))

N are the rows. They are held out one after the other, each time the likeliest. The odds of a set are the product
of these steps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.inference import odds, priors
from procedures.inference.marginal import log_mean

MOST_WRONG = 4  # rows of one table: with more of them it is not worth a calibration
LEAST_RIGHT = 0.75  # of the rows: those that contradict are few


@dataclass(frozen=True, slots=True)
class HeldOut:
    """A row held out: by how much it is ``off`` what the others predict, also in sigmas, and ln of the odds."""

    off: float
    sigmas: float
    log_odds: float


@dataclass(frozen=True, slots=True)
class WrongRow:
    """A row that contradicts the others.

    ``row`` is its number from 0, ``off`` how much it is off what the others predict, ``sigmas`` that in standard
    uncertainties. ``alternatives`` are other rows that may be the wrong one, with their probabilities.
    """

    row: int
    probability: float
    off: float
    sigmas: float
    alternatives: tuple[tuple[int, float], ...] = ()


Hold = Callable[[Sequence[int]], Mapping[int, HeldOut]]  # each candidate held out in turn where some are gone


def log_odds(weight: FloatArray, squares: FloatArray, tried: int, dof: float = np.inf) -> float:
    """Return ln of the odds that a row is wrong, one of ``tried``.

    Parameters
    ----------
    weight : (m,), ln of the weight of each case with the row right
    squares : (m,) [sigma^2], the square of the row's error there
    dof : to which the noise is known in each case
    """
    gain = float(log_mean(weight + odds.gain_of_squares(squares, 1, dof)) - log_mean(weight))
    return odds.log_odds(gain, tried)


def find_wrong_rows(hold: Hold, rows: int) -> tuple[WrongRow, ...]:
    """Find which of so many rows contradict the others, as they are likelier than none.

    What ``hold`` numbers from ``rows`` on are no rows but other explanations, which compete with them.
    """
    most = min(MOST_WRONG, int((1 - LEAST_RIGHT) * rows))
    out, total, best, number = list[int](), 0.0, 0.0, 0
    while len(out) < most and (found := hold(out)):
        each = max(found, key=lambda one: found[one].log_odds)
        out, total = [*out, each], total + found[each].log_odds
        if total > best:
            best, number = total, len(out)
    held = out[:number]
    return tuple(
        _wrong_row(hold, each, [one for one in held if one != each], rows) for each in held if each < rows
    )


def _wrong_row(hold: Hold, row: int, others: Sequence[int], rows: int) -> WrongRow:
    """Return a row with its share of the probability where the ``others`` that were found are held out."""
    found = hold(others)
    shares = odds.shares({str(each): one.log_odds for each, one in found.items()})
    likely = sorted(((int(name), share) for name, share in shares.items()), key=lambda each: -each[1])
    alternatives = tuple(
        each for each in likely if each[0] != row and each[0] < rows and each[1] >= priors.NEGLIGIBLE
    )
    return WrongRow(row, shares[str(row)], found[row].off, found[row].sigmas, alternatives)

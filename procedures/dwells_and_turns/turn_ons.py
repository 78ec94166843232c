"""A unit switched off and on within a campaign: each turn-on has biases of its own, and the mean is solved.

With J turn-ons the bias of turn-on j is ``b + s_j``, the s_j summing to nought: b is their mean, a better guess of
the next turn-on's than any one of them. The steps are J - 1 more parameters per axis, ``s = Z t`` with orthonormal
contrasts Z (Helmert), with a prior so wide that it only holds what the steps do not tell. They are fitted with all
else and then profiled out (Frisch, Waugh 1933): what is left is a fit of the parameters asked for, its covariance
holds what the steps leave open, and its data are freed of the steps found.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.statistics.least_squares import Fit, joined_rows, minimise

TurnOn = tuple[int, int]
"""Campaign and turn-on within it, from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class TurnOnFit:
    """A fit without the steps; ``steps`` (n, 3) of the bias of every row's turn-on off the mean [output/s].

    ``spread`` (3,) is 1 sigma of the mean as an estimate of what the bias is at another turn-on's: the standard
    error of J turn-ons; zero where there is one. ``absorbed`` (m, q) are orthonormal columns of what the q steps
    that were fitted besides take of the whitened rows.
    """

    fit: Fit
    steps: FloatArray
    spread: FloatArray
    absorbed: FloatArray


def contrasts(turn_ons: Sequence[TurnOn]) -> FloatArray:
    """Return Z (n, m) of the rows' turn-ons: their steps are ``Z t``; no column where no campaign has a second."""
    columns = list[FloatArray]()
    for campaign in sorted({number for number, _ in turn_ons}):
        numbers = sorted({on for of, on in turn_ons if of == campaign})
        of_row = np.array([numbers.index(on) if of == campaign else -1 for of, on in turn_ons])
        for k in range(1, len(numbers)):
            column = np.concatenate((np.full(k, 1.0), [-k], np.zeros(len(numbers) - k - 1), [0.0]))
            columns.append(column[of_row] / np.sqrt(k * (k + 1)))
    return np.column_stack(columns) if columns else np.zeros((len(turn_ons), 0))


def fit_with_turn_ons(
    residual: Callable[[FloatArray, FloatArray], FloatArray], start: FloatArray, scale: FloatArray,
    turn_ons: Sequence[TurnOn], plausible: FloatArray,
) -> TurnOnFit:  # fmt: skip
    """Minimise ``residual(x, steps)`` and the steps of the turn-ons with it, all differences at once.

    Parameters
    ----------
    residual : takes x (..., p) and each row's step (..., n, 3) [output/s] to whitened residuals (..., m)
    start, scale : (p,), as `minimise` takes them
    turn_ons : of the n rows
    plausible : (3,) [output/s], 1 sigma of a step before the first count
    """
    Z, p = contrasts(turn_ons), len(start)
    m = 3 * Z.shape[1]
    if not m:
        none = np.zeros((len(turn_ons), 3))
        fit = minimise(lambda x: residual(x, none), start, scale, at_once=True)
        return TurnOnFit(fit, none, np.zeros(3), np.zeros((len(fit.residual), 0)))
    sigma = np.tile(plausible, Z.shape[1])

    def whole(x: FloatArray) -> FloatArray:
        steps = Z @ x[..., p:].reshape(*x.shape[:-1], -1, 3)
        return joined_rows(x, residual(x[..., :p], steps), x[..., p:] / sigma)

    fit = minimise(whole, np.concatenate((start, np.zeros(m))), np.concatenate((scale, sigma)), at_once=True)
    Q = np.linalg.qr(fit.jacobian[:, p:])[0]
    own = fit.jacobian[:, :p]
    profiled = (own - Q @ (Q.T @ own))[:-m]
    steps = Z @ fit.x[p:].reshape(-1, 3)
    left = Fit(fit.x[:p], fit.covariance[:p, :p], fit.residual[:-m], profiled)
    return TurnOnFit(left, steps, _spread(turn_ons, steps), Q[:-m])


def _spread(turn_ons: Sequence[TurnOn], steps: FloatArray) -> FloatArray:
    """Return the standard error (3,) of the mean over turn-ons; of several campaigns the root mean square."""
    found = list[FloatArray]()
    for campaign in {number for number, _ in turn_ons}:
        of = {on: steps[i] for i, (number, on) in enumerate(turn_ons) if number == campaign}
        if len(of) > 1:
            found.append(np.sum(np.square(list(of.values())), axis=0) / (len(of) * (len(of) - 1)))
    return np.sqrt(np.mean(found, axis=0)) if found else np.zeros(3)

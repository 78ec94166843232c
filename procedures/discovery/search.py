"""How much of what is left each term of the library would explain, and how often noise alone would seem to.

With the model fitted, Q its whitened columns and r what is left, a term's columns W are taken beside it,
``W - Q Q'W``, and made orthonormal (Cholesky): U. It gains ``|U'r|^2``, chi-square of as many degrees of freedom
as U has columns, or by its best sensor alone; the less likely counts, twice. Terms overlap, so that no count is
right: noise z ~ N(0, 1) drawn anew takes the residual's place, and p is how often the best of the library is as
good (the maximum's own distribution: Westfall and Young 1993; exact where noise is normal and its sigma known).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.linear_model import LinearFit
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery.library import LibraryTerm, Rows

MIN_LEFT = 1e-3  # of a column's squares that the model must leave for it to be looked at
JITTER = 1e-6  # of a column, within which two of a term's are one
DRAWS = 400
BLOCK = 800  # terms whose columns are held at a time
SEED = 20210


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Of every term: its gain of chi-square (t,), its ln p by itself (t,); ``log_p_of_best`` (d,) of noise."""

    gain: FloatArray
    log_p: FloatArray
    log_p_of_best: FloatArray

    def family_p(self, number: int) -> float:
        """Return how often the best of the library would be as good as a term by noise alone."""
        as_good = int(np.sum(self.log_p_of_best <= self.log_p[number]))
        return (1 + as_good) / (1 + len(self.log_p_of_best))


def beside(fit: LinearFit, W: FloatArray | NDArray[np.float32]) -> FloatArray:
    """Return orthonormal columns (rows, t, k) of what W (n, t, k) in sigmas add beside a fit; else nought."""
    n, shape = len(W), W.shape[1:]
    flat = W.reshape(n, -1).astype(np.float64)
    size = np.sum(flat**2, axis=0)
    along = fit.Q[:n].T @ flat
    left = np.concatenate((flat, np.zeros((len(fit.Q) - n, flat.shape[1])))) - fit.Q @ along
    squares = np.sum(left**2, axis=0)
    kept = (squares > MIN_LEFT * size) & np.isfinite(squares) & (squares > 0)
    left = np.where(kept, left / np.sqrt(np.where(kept, squares, 1.0)), 0.0).reshape(-1, *shape)
    each = left.transpose(1, 0, 2)  # (t, rows, k)
    G = np.swapaxes(each, 1, 2) @ each
    G += np.eye(shape[1]) * np.where(np.diagonal(G, axis1=1, axis2=2) > 0, JITTER, 1.0)[:, None, :]
    L = np.linalg.cholesky(G)
    U: FloatArray = np.linalg.solve(L, np.swapaxes(each, 1, 2)).transpose(2, 0, 1)
    return U


def gain_of(evidence: Evidence, fit: LinearFit, H: FloatArray) -> float:
    """Return the chi-square that columns H (n, k) gain beside a fit."""
    U = beside(fit, (H / evidence.sigma[:, None])[:, None, :])[:, 0]
    return float(np.sum((U.T @ fit.whole) ** 2))


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Terms of one triad and as many products each: their numbers (t,), and columns (n, t, k) in sigmas."""

    numbers: IntArray
    products: int
    W: NDArray[np.float32]


def blocks_of(rows: Rows, terms: Sequence[LibraryTerm]) -> list[Block]:
    """Return the columns of a whole library, in single precision."""
    kinds = [(len(term.products), term.triad) for term in terms]
    found = list[Block]()
    for kind in sorted(set(kinds)):
        numbers = np.array([i for i, each in enumerate(kinds) if each == kind])
        for begin in range(0, len(numbers), BLOCK):
            here = numbers[begin : begin + BLOCK]
            found.append(Block(here, kind[0], rows.of([terms[i] for i in here]).astype(np.float32)))
    return found


def scores(fit: LinearFit, blocks: Sequence[Block], dof: float, seed: int = SEED) -> Scores:
    """Score every term beside a fit whose sigmas are not widened; ``dof`` are those behind the rows' sigma.

    ``seed`` draws the noise.
    """
    both = np.column_stack((fit.whole, noise_of(fit, dof, seed))).astype(np.float32)
    size = 1 + max(int(block.numbers[-1]) for block in blocks)
    gain, log_p, best = np.zeros(size), np.zeros(size), np.zeros(DRAWS)
    for block in blocks:
        U = beside(fit, block.W)
        t, k = U.shape[1:]
        found = (U.reshape(len(U), -1).T.astype(np.float32) @ both).reshape(t, k, -1) ** 2
        seen = np.sum(np.any(U, axis=0), axis=1)
        joint = found.sum(axis=1)
        alone = found.reshape(t, block.products, -1, found.shape[2]).sum(axis=1).max(axis=1)
        gain[block.numbers] = joint[:, 0]
        log_p[block.numbers] = _log_p(joint[:, 0], alone[:, 0], seen, block.products)
        for degrees in np.unique(seen[seen > 0]):
            here, many = seen == degrees, np.full(DRAWS, degrees)
            of_best = _log_p(joint[here, 1:].max(axis=0), alone[here, 1:].max(axis=0), many, block.products)
            best = np.minimum(best, of_best)
    return Scores(gain, log_p, best)


def noise_of(fit: LinearFit, dof: float, seed: int = SEED) -> FloatArray:
    """Return what a fit leaves of noise alone (rows, DRAWS) [sigma]; ``dof`` are those behind the rows' sigma."""
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((len(fit.whole), DRAWS))
    noise -= fit.Q @ (fit.Q.T @ noise)
    if np.isfinite(dof):
        noise *= np.sqrt(dof / rng.chisquare(dof, DRAWS))
    return noise


def _log_p(joint: FloatArray, alone: FloatArray, k: IntArray, products: int) -> FloatArray:
    """Return the lesser ln p of a term's sensors together and of its best alone, both counted."""
    sensors = np.maximum(k // products, 1)
    of_joint = chi2.logsf(joint, np.maximum(k, 1))
    of_alone = chi2.logsf(alone, products) + np.log(sensors)
    found: FloatArray = np.where(k > 0, np.minimum(np.minimum(of_joint, of_alone) + np.log(2), 0.0), 0.0)
    return found

"""Expectation propagation over the nodes of counted paths, many at once: a few large sums cost less.

The paths share nothing: in the tridiagonal precision of their random walks no path is linked to the next. Each has
its own noise and rate, and is taken out when that has settled.

`rate_within_counts` is for a dwell near a simple fraction of a count per sample, whose rate shows only where the
count's pattern slips: the straight lines that pass every count's interval are counted, each as likely as any
other.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpttrf, dpttrs

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.count_kernels import INITIAL_STATEMENTS, MAX_INTERVAL_SIGMAS, interval_moments

EVIDENCE_TOLERANCE = 0.1  # nats per sweep by which a path that has settled still moves


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """A path's nodes: times ``t`` (m,) [samples]; ``linked`` (m,) is 1 where one continues a segment, else 0.

    ``low`` (m,) is the least that the output S can have been [counts], ``basis`` (m,) that of theta, the rate.
    """

    t: FloatArray
    linked: FloatArray
    low: FloatArray
    basis: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Sites:
    """What each node of a path says: precision ``tau`` (m,) and precision times mean ``nu`` (m,).

    ``theta``, its ``variance`` and the log ``evidence``.
    """

    tau: FloatArray
    nu: FloatArray
    theta: float
    variance: float
    evidence: float


def propagate(paths: Sequence[Nodes], noises: Sequence[float], sweeps: int, tolerance: float) -> list[Sites]:
    """Refine the sites of each path until its theta moves by less than ``tolerance`` of its sigma.

    The sites start as those of a uniform remainder, but all together they say no more than `INITIAL_STATEMENTS` of
    them would: where the output hardly moves, neighbours repeat each other. The evidence is -inf where the noise
    is too small for any path through the intervals.

    Parameters
    ----------
    paths : at least one
    noises : of each path, counts per sqrt(sample)
    sweeps : at the most
    tolerance : of theta's sigma
    """
    found = dict[int, Sites]()
    left = _Left(paths, noises)
    for sweep in range(1, sweeps + 1):
        cavity = left.cavity()
        lost = ~left.is_met(*cavity[-2:])
        if lost.any():
            left.take_out(lost, np.full(len(lost), -math.inf), found)
            cavity = left.cavity()
        if not len(left.numbers):
            break
        before, evidence_before = left.theta, left.evidence
        evidence = left.refine(0.9 if sweep < 3 else 0.6, *cavity)
        if sweep > 2 or sweep == sweeps:
            has_settled = np.abs(left.theta - before) < tolerance * np.sqrt(left.covariance)
            # theta may only be turning round
            has_settled &= np.abs(evidence - evidence_before) < EVIDENCE_TOLERANCE
            left.take_out(has_settled | (sweep == sweeps), evidence, found)
    return [found[number] for number in range(len(paths))]


def output_under_sites(
    path: Nodes, noise: float, tau: FloatArray, nu: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return mean (m,) and variance (m,) of the output S [counts] under sites ``tau`` and ``nu`` (m,)."""
    left = _Left([path], [noise])
    left.tau, left.nu = tau, nu
    left.smooth()
    return left.mean, left.variance


class _Left:
    """The paths that have not settled yet, their nodes one after the other."""

    by_node = ("link", "TB", "low", "tau", "nu", "mean", "variance")
    by_path = ("numbers", "sizes", "BTB", "walk", "theta", "covariance", "log_norm", "evidence")

    def __init__(self, paths: Sequence[Nodes], noises: Sequence[float]) -> None:
        t, linked, basis = (np.concatenate([getattr(p, n) for p in paths]) for n in ("t", "linked", "basis"))
        self.low = np.concatenate([path.low for path in paths])
        self.numbers, self.sizes = np.arange(len(paths)), np.array([len(path.t) for path in paths])
        self.starts = np.cumsum(self.sizes) - self.sizes
        # of the step to each node; none to a segment's first, which may be at the time at which another ended
        self.link, change = np.zeros(len(t)), np.zeros(len(t))
        walked = np.repeat(np.square(noises), self.sizes)[1:] * (t[1:] - t[:-1])
        np.divide(1.0, walked, out=self.link[1:], where=linked[1:] > 0)
        np.subtract(basis[1:], basis[:-1], out=change[1:])
        step = self.link * change
        self.TB = step.copy()
        self.TB[:-1] -= step[1:]
        self.BTB = self.sums(step * change)
        self.walk = 0.5 * self.sums(np.log(self.link, out=np.zeros(len(t)), where=self.link > 0))
        self.tau = np.repeat(12.0 * np.minimum(1.0, INITIAL_STATEMENTS / self.sizes), self.sizes)
        self.nu = self.tau * (self.low + 0.5)
        self.evidence = np.full(len(paths), -math.inf)
        self.smooth()

    def sums(self, values: FloatArray) -> FloatArray:
        """Return the sum over each path (paths,) of ``values`` (m,)."""
        return np.add.reduceat(values, self.starts)

    def at_nodes(self, values: FloatArray) -> FloatArray:
        """Return each path's value (paths,) at its nodes (m,), or as the one that it is for all."""
        return values if len(values) == 1 else np.repeat(values, self.sizes)

    def smooth(self) -> None:
        """Find mean and variance of S and theta under the sites; A is that of `theta_of_first_and_all`.

        With d the pivots from the first node on, e those from the last: diag A^-1 = 1 / (d + e - diag A).
        """
        diagonal = self.tau + self.link
        diagonal[:-1] += self.link[1:]
        pivot, factor, _ = dpttrf(diagonal, -self.link[1:])
        back, _, _ = dpttrf(diagonal[::-1], -self.link[:0:-1])
        right = np.empty((len(diagonal), 2), order="F")
        right[:, 0], right[:, 1] = self.nu, self.TB
        solved, _ = dpttrs(pivot, factor, right)
        level, bent = solved[:, 0], solved[:, 1]
        information, h = self.BTB - self.sums(self.TB * bent), self.sums(self.TB * level)
        self.covariance = 1.0 / information
        self.theta = self.covariance * h
        exponent = self.sums(self.nu * level - np.log(pivot)) + h * self.theta
        self.log_norm = self.walk + 0.5 * (exponent - np.log(information))
        self.mean = level + bent * self.at_nodes(self.theta)
        self.variance = 1.0 / (pivot + back[::-1] - diagonal) + bent**2 * self.at_nodes(self.covariance)

    def cavity(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return what the other nodes say of each (m,): precision, mean, sigma; the interval's ends by it."""
        precision = np.maximum(1.0 / self.variance - self.tau, 1e-3 / self.variance)
        c = (self.mean / self.variance - self.nu) / precision
        s = 1.0 / np.sqrt(precision)
        below = (self.low - c) / s
        return precision, c, s, below, below + 1.0 / s

    def is_met(self, below: FloatArray, above: FloatArray) -> BoolArray:
        """Say of each path (paths,) whether every node can lie in its interval, its ends (m,) [sigma]."""
        met: BoolArray = np.maximum.reduceat(below, self.starts) < MAX_INTERVAL_SIGMAS
        met &= np.minimum.reduceat(above, self.starts) > -MAX_INTERVAL_SIGMAS
        return met

    def refine(
        self, damping: float, precision: FloatArray, c: FloatArray, s: FloatArray, below: FloatArray,
        above: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """Move every site towards what its interval says, and smooth; return the log evidence before (paths,)."""
        log_p, x, w = interval_moments(below, above)
        exponent = (c * precision + self.nu) ** 2 / (precision + self.tau) - c * c * precision
        evidence = self.log_norm + self.sums(log_p + 0.5 * (np.log(1 + self.tau / precision) - exponent))
        tilted = precision / w
        self.tau = self.tau + damping * (np.maximum(tilted - precision, 0.0) - self.tau)
        self.nu = self.nu + damping * ((c + s * x) * tilted - c * precision - self.nu)
        self.evidence = evidence
        self.smooth()
        return evidence

    def take_out(self, which: BoolArray, evidence: FloatArray, found: dict[int, Sites]) -> None:
        """Enter what was found of some paths (paths,), and go on without them."""
        if not which.any():
            return
        for i in np.flatnonzero(which):
            part = slice(self.starts[i], self.starts[i] + self.sizes[i])
            found[int(self.numbers[i])] = Sites(
                self.tau[part].copy(), self.nu[part].copy(), float(self.theta[i]), float(self.covariance[i]),
                float(evidence[i]),
            )  # fmt: skip
        nodes = np.repeat(~which, self.sizes)
        for names, kept in ((self.by_node, nodes), (self.by_path, ~which)):
            for name in names:
                setattr(self, name, getattr(self, name)[kept])
        self.starts = np.cumsum(self.sizes) - self.sizes


REACH, STEP = 8.0, 0.1  # of the sigma given: how far from it lines are tried, and how densely


def rate_within_counts(
    t: FloatArray, low: FloatArray, linked: FloatArray, mean: float, std: float
) -> tuple[float, float] | None:
    """Return mean and 1 sigma of the slopes of the lines that fit [counts per sample]; None where none does.

    A slope is as likely as the room that it leaves its line is wide: in each gap-free segment the line lies
    between the highest of ``low`` and the lowest of ``low`` + 1, and each segment has a level of its own.

    Parameters
    ----------
    t, low : nodes (m,): time [samples], and the least that the output can have been there [counts]
    linked : (m,) 1 where a node continues a segment, else 0
    mean, std : about where the slopes are [counts per sample]
    """
    slopes = mean + std * np.arange(-REACH, REACH + STEP, STEP)
    remainder = low - slopes[:, None] * t
    starts = np.flatnonzero(linked == 0)
    room = 1 + np.minimum.reduceat(remainder, starts, axis=1) - np.maximum.reduceat(remainder, starts, axis=1)
    weight = np.prod(np.maximum(room, 0.0), axis=1)
    if not weight.any():
        return None
    weight /= weight.sum()
    centre = float(weight @ slopes)
    return centre, float(np.sqrt(weight @ (slopes - centre) ** 2))

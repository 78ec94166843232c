import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm, truncnorm

from procedures.arrays import FloatArray
from procedures.counts.count_kernels import (
    interval_moments,
    smooth,
)
from procedures.counts.count_propagation import Nodes, Sites, propagate

Case = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, float]


def problem(seed: int, m: int = 9, p: int = 2, segments: int = 2) -> Case:
    """Times, links, sites and basis of a small path in gap-free segments."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 3.0, m))
    linked = np.ones(m)
    linked[:: math.ceil(m / segments)] = 0
    x = 2 * (t - t.mean()) / (t[-1] - t[0])
    basis = np.stack([x / 2, (x**2 - 1) / 4, (x**3 - x) / 4][:p], axis=1)
    return t, linked, rng.uniform(0.5, 12, m), rng.standard_normal(m), np.ascontiguousarray(basis), 0.3


def dense(case: Case) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """The same posterior from the joint precision of all of (S, theta) at once."""
    t, linked, tau, nu, basis, noise = case
    m, p = basis.shape
    D = np.array([np.eye(m)[i] - np.eye(m)[i - 1] for i in range(1, m) if linked[i]])
    w = np.array([1 / (noise**2 * (t[i] - t[i - 1])) for i in range(1, m) if linked[i]])
    G = np.hstack((D, -D @ basis))  # steps of W = S - B theta
    precision = G.T @ (w[:, None] * G)
    precision[:m, :m] += np.diag(tau)
    covariance = np.linalg.inv(precision)
    mean = covariance @ np.concatenate((nu, np.zeros(p)))
    log_norm = 0.5 * (np.log(w).sum() - np.linalg.slogdet(precision)[1] + nu @ mean[:m])
    return mean[:m], np.diag(covariance)[:m], mean[m:], covariance[m:, m:], float(log_norm)


@pytest.mark.parametrize("p", [1, 2, 3])
@pytest.mark.parametrize("segments", [1, 2, 3])
def test_smooth_is_dense_linear_algebra(p: int, segments: int) -> None:
    for seed in range(5):
        case = problem(seed, 12, p, segments)
        for got, expected in zip(smooth(*case), dense(case), strict=True):
            assert got == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_smooth_keeps_its_digits_where_noise_is_small() -> None:
    t, linked, tau, nu, basis, _ = problem(1, 12, 1, 2)
    case = (t, linked, tau, nu, basis, 1e-4)
    mean, variance, theta, covariance, _ = smooth(*case)
    # the limit of no noise: each segment is a line of free level, weighted least squares
    segment = np.cumsum(linked == 0) - 1
    A = np.hstack((basis, (segment[:, None] == np.arange(2)) * 1.0))
    exact = np.linalg.inv(A.T @ (tau[:, None] * A))
    line = exact @ A.T @ nu
    assert theta == pytest.approx(line[:1], abs=1e-4 * np.sqrt(exact[0, 0]))
    assert covariance[0, 0] == pytest.approx(exact[0, 0], rel=1e-4)
    assert mean == pytest.approx(A @ line, abs=1e-4)
    assert variance == pytest.approx(np.einsum("ij,jk,ik->i", A, exact, A), rel=1e-4)


@settings(max_examples=150)
@given(st.floats(-29, 29), st.floats(1e-6, 40))
def test_interval_moments_are_those_of_a_truncated_normal(a: float, width: float) -> None:
    b = a + width
    if not b > -29:
        return
    log_p, mean, variance = (float(each) for each in interval_moments(np.array(a), np.array(b)))
    low, high = (a, b) if a + b > 0 else (-b, -a)  # scipy too keeps its digits in one tail only
    expected = norm.logsf(low) + math.log(-math.expm1(norm.logsf(high) - norm.logsf(low)))
    if width > 1e-3:
        assert log_p == pytest.approx(expected, rel=1e-6, abs=2e-4)
        assert mean == pytest.approx(truncnorm.mean(a, b), abs=2e-3 * min(width, 1))
        reference = float(truncnorm.var(a, b))
        if reference > 1e-9:  # below, scipy's own digits end
            assert variance == pytest.approx(reference, rel=0.02)
    assert a <= mean <= b
    assert 0 < variance <= min(1.0, width**2 / 4) + 1e-12


def alone(
    t: FloatArray, linked: FloatArray, low: FloatArray, basis: FloatArray, noise: float, sweeps: int, within: float
) -> Sites:
    [found] = propagate([Nodes(t, linked, low, basis[:, 0])], [noise], sweeps, within)
    return found


def lows(
    seed: int, m: int, noise: float, rate: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """A counter's path: integer parts of a line plus a random walk, about its own least-squares line."""
    rng = np.random.default_rng(seed)
    t = np.arange(m) - (m - 1) / 2
    total = (
        rng.random() + rate * np.arange(m) + noise * np.concatenate(([0], np.cumsum(rng.standard_normal(m - 1))))
    )
    count = np.floor(total)
    slope = float(np.polyfit(t, count, 1)[0])
    low = count - slope * t
    linked = np.ones(m)
    linked[0] = 0
    return t, linked, low - low.mean() - 0.5, np.ascontiguousarray((t / (t[-1] - t[0]))[:, None]), slope


def enumerated(t: FloatArray, low: FloatArray, noise: float) -> tuple[float, float, float]:
    """Mean and variance of theta, and the log evidence, by a grid over theta and a filter over S on a grid.

    The level is flat over all that the first interval allows, theta is flat.
    """
    span = t[-1] - t[0]
    theta = np.linspace(-3.0, 3.0, 121)
    cells = 100
    S = (np.arange(cells) + 0.5) / cells  # place inside the interval, common to all nodes
    log_weight = np.empty_like(theta)
    for k, each in enumerate(theta):
        belief, log_p = np.ones(cells) / cells, 0.0
        for i in range(1, len(t)):
            step = t[i] - t[i - 1]
            drift = each / span * step
            # probability of landing in each cell, by cell edges
            edges = np.arange(cells + 1) / cells + low[i]
            at = (edges[None, :] - (S + low[i - 1])[:, None] - drift) / (noise * np.sqrt(step))
            belief = belief @ np.diff(norm.cdf(at), axis=1)
            total = belief.sum()
            log_p += np.log(max(total, 1e-300))
            belief /= max(total, 1e-300)
        log_weight[k] = log_p
    peak = log_weight.max()
    weight = np.exp(log_weight - peak)
    mean = np.sum(weight * theta) / weight.sum()
    variance = np.sum(weight * (theta - mean) ** 2) / weight.sum()
    return float(mean), float(variance), float(peak + np.log(weight.sum() * (theta[1] - theta[0])))


@pytest.mark.parametrize(("seed", "noise"), [(1, 0.2), (2, 0.2), (3, 0.4), (4, 0.1)])
def test_propagation_is_the_exact_posterior_on_a_small_problem(seed: int, noise: float) -> None:
    t, linked, low, basis, _ = lows(seed, 7, noise, 0.23)
    mean, variance, *_ = enumerated(t, low, noise)
    got = alone(t, linked, low, basis, noise, 60, 1e-6)
    # a Gaussian stand-in for a clipped posterior: 0.012 sigma and 4 % were measured on these
    assert abs(got.theta - mean) < 0.05 * np.sqrt(variance)
    assert got.variance == pytest.approx(variance, rel=0.12)

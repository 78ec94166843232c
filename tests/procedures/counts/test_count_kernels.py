import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm, truncnorm

from procedures.arrays import FloatArray, IntArray
from procedures.counts.count_kernels import interval_moments, theta_of_first_and_all
from procedures.counts.count_propagation import Nodes, Sites, output_under_sites, propagate

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
def test_the_posterior_under_sites_is_dense_linear_algebra(p: int, segments: int) -> None:
    for seed in range(5):
        t, linked, tau, nu, basis, noise = case = problem(seed, 12, p, segments)
        mean, variance, *of_first, _ = dense((t, linked, tau, nu, basis[:, :1], noise))
        found = output_under_sites(Nodes(t, linked, np.zeros(len(t)), basis[:, 0]), noise, tau, nu)
        first, every = theta_of_first_and_all(*case)
        expected = (mean, variance, *of_first, *dense(case)[2:4])
        for got, wanted in zip((*found, *first, *every), expected, strict=True):
            assert got == pytest.approx(wanted, rel=1e-8, abs=1e-9)


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


SWEEPS, TOLERANCE = 60, 1e-3
NOISE, SAMPLES = 5e-4, 600


def counted(rng: np.random.Generator, rate: float, noise: float, n: int) -> IntArray:
    """Return the count at every node of a straight line with a random walk, from a random remainder."""
    output = rng.random() + np.concatenate(([0.0], np.cumsum(rate + noise * rng.standard_normal(n))))
    return np.floor(output).astype(np.int64)


def nodes_of(count: IntArray, rate: float) -> Nodes:
    """Return every node of a dwell without gaps, about a line of ``rate`` counts per sample."""
    t = np.arange(len(count)) - (len(count) - 1) / 2
    low = count - rate * t
    linked = np.concatenate(([0.0], np.ones(len(t) - 1)))
    return Nodes(t, linked, low - low.mean() - 0.5, t / (t[-1] - t[0]))


def grid_log_likelihood(count: IntArray, rates: FloatArray, noise: float) -> FloatArray:
    """Return ln P(count) by rate, the remainder's density carried on a grid from sample to sample."""
    size = int(np.ceil(3 / noise))
    at = (np.arange(size) + 0.5) / size
    total = np.zeros(len(rates))
    for i, rate in enumerate(rates):
        density, steps = np.ones(size), np.diff(count)
        away = {step: at[:, None] - at[None, :] - (rate - step) for step in np.unique(steps)}
        unit = noise * np.sqrt(2 * np.pi) * size
        on = {step: np.exp(-0.5 * (each / noise) ** 2) / unit for step, each in away.items()}
        for step in steps:
            density = on[step] @ density
            total[i] += np.log(density.mean() + 1e-300)
            density /= density.mean() + 1e-300
    return total


@pytest.mark.parametrize("seed", [161, 750])
@pytest.mark.parametrize("noise", np.exp(np.arange(-42, -36) / 4).tolist())
def test_a_rate_that_turns_round_has_not_settled(seed: int, noise: float) -> None:
    """Noise tried is a tenth of what it is: sweep by sweep the evidence falls by a hundred nats and more."""
    rng = np.random.default_rng(seed)
    rate = rng.uniform(0, 1)
    count = counted(rng, rate, NOISE, SAMPLES)
    nodes = nodes_of(count, np.polyfit(np.arange(SAMPLES + 1), count, 1)[0])
    (found,), (settled,) = (propagate([nodes], [noise], SWEEPS, tolerance) for tolerance in (TOLERANCE, 0.0))
    assert found.evidence == pytest.approx(settled.evidence, abs=0.5)
    assert found.theta == pytest.approx(settled.theta, abs=0.2 * np.sqrt(settled.variance))


@pytest.mark.parametrize("seed", range(2))
def test_rate_and_evidence_are_those_of_a_density_on_a_grid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate, n, evidence, grid = rng.uniform(-1, 1), 60, [], []
    count = counted(rng, rate, 0.02, n)
    for noise in (0.015, 0.03, 0.06):
        (found,) = propagate([nodes_of(count, rate)], [noise], SWEEPS, TOLERANCE)
        sigma = np.sqrt(found.variance) / n
        rates = rate + found.theta / n + sigma * np.linspace(-5, 5, 41)
        log = grid_log_likelihood(count, rates, noise)
        weight = np.exp(log - log.max())
        mean = np.sum(weight * rates) / np.sum(weight)
        std = np.sqrt(np.sum(weight * (rates - mean) ** 2) / np.sum(weight))
        assert rate + found.theta / n == pytest.approx(mean, abs=0.1 * std)
        assert sigma == pytest.approx(std, rel=0.1)
        evidence.append(found.evidence)
        grid.append(log.max() + np.log(np.sum(weight) * (rates[1] - rates[0])))
    assert np.diff(evidence) == pytest.approx(np.diff(grid), abs=0.4)

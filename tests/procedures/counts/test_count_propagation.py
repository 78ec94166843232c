import numpy as np
import pytest

from procedures.arrays import FloatArray, IntArray
from procedures.counts.count_propagation import Nodes, propagate

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

"""The white noise of a channel, estimated from its counts, and whether counting errors are white.

Noises are tried in steps of their logarithm. A search says which it wants tried of which paths, and goes on when
that is done: what several channels want at a time is tried together, which costs little more than one of them.
"""

from collections.abc import Generator, Sequence
from typing import Protocol, TypeAlias, TypeVar

import numpy as np

from procedures.arrays import IntArray
from procedures.counts.sample_records import Samples

MAX_ADMISSIONS = 4
NOISE_STEPS_PER_E = 4  # noises tried per factor e
NOISE_STEP_RANGE = (-42, 0)  # steps of the logarithm of counts per sqrt(sample): 2.8e-5 to 1
MAX_EVIDENCE_DROP_NATS = 5.0  # nats below the best at which a noise is given up
# By which the evidence is divided: neighbouring nodes say in part the same, which it counts twice
EVIDENCE_REPEATED = 1.5
# The prior of a noise s is s^-NOISE_PRIOR_EXPONENT ds / s; it matters below about four counts a dwell
NOISE_PRIOR_EXPONENT = 0.25


class NoisyPath(Protocol):
    """One channel's counts in one dwell; ``edges`` as `RateEstimate.edges`."""

    edges: int

    def take(self, noise: float) -> float:
        """Take what was found at a noise tried; return the log evidence."""
        ...

    def admit(self, noise: float) -> bool:
        """Take in the nodes that what was taken leaves in doubt; say whether there were any."""
        ...


Path = TypeVar("Path", bound=NoisyPath)
Result = TypeVar("Result")
Tries: TypeAlias = list[tuple[Path, float]]  # a path, and a noise [count/sqrt(sample)] at which it is to be tried
Search: TypeAlias = Generator[Tries[Path], None, Result]
Weights: TypeAlias = list[tuple[float, float]]  # noises, and the share of each


def noise_of(step: float) -> float:
    """Return a noise [count/sqrt(sample)] by its step."""
    return float(np.exp(step / NOISE_STEPS_PER_E))


def noise_posterior(paths: Sequence[Path]) -> Search[Path, Weights]:
    """Search (noise, weight) around the most likely noise of all paths of a channel."""
    decisive = max(paths, key=lambda path: path.edges)  # where one path leads, all need few steps
    best = yield from most_likely_noise([decisive], sum(NOISE_STEP_RANGE) // 2, NOISE_STEPS_PER_E, {})
    for _ in range(MAX_ADMISSIONS):
        found: dict[int, float] = {}
        best = yield from most_likely_noise(paths, best, 1, found)
        for path in paths:
            path.take(noise_of(best))
        fresh = [path.admit(noise_of(best)) for path in paths]
        if not any(fresh):
            break
    return (yield from _noise_grid(paths, best, found))


def most_likely_noise(paths: Sequence[Path], best: int, stride: int, found: dict[int, float]) -> Search[Path, int]:
    """Walk to the most likely noise in ever smaller strides; where none is possible, to a larger one."""
    low, high = NOISE_STEP_RANGE
    while stride:
        near = [k for k in (best - stride, best, best + stride) if low <= k <= high]
        yield from _evidence(paths, near, found)
        leader = max(near, key=lambda k: (found[k], k))
        stride = stride // 2 if leader == best else stride
        best = leader
    return best


def _evidence(paths: Sequence[Path], steps: Sequence[int], found: dict[int, float]) -> Search[Path, None]:
    """Enter the log probability of all the counts at the noises of ``steps``, up to a constant, each once."""
    new = [step for step in steps if step not in found]
    if new:
        yield [(path, noise_of(step)) for step in new for path in paths]
    for step in new:
        found[step] = sum(path.take(noise_of(step)) for path in paths)


def _noise_grid(paths: Sequence[Path], best: int, found: dict[int, float]) -> Search[Path, Weights]:
    """Weigh every noise within `MAX_EVIDENCE_DROP_NATS` of the best, or put one for all if that is hardly one."""
    low, high = NOISE_STEP_RANGE
    fall, ends = {best: 0.0}, {-1: best, 1: best}
    while ends:
        ends = {way: k + way for way, k in ends.items() if low <= k + way <= high}
        yield from _evidence(paths, list(ends.values()), found)
        drops = {way: (found[best] - found[k]) / EVIDENCE_REPEATED for way, k in ends.items()}
        ends = {way: k for way, k in ends.items() if drops[way] < MAX_EVIDENCE_DROP_NATS}
        fall |= {k: drops[way] for way, k in ends.items()}
    if len(fall) <= 3 and low < best < high:
        below, above = ((found[best] - found[best + k]) / EVIDENCE_REPEATED for k in (-1, 1))
        if np.isfinite(below + above):
            mode = best + (below - above) / (2 * (below + above))
            return [(float(np.exp(mode / NOISE_STEPS_PER_E + 1 / ((below + above) * NOISE_STEPS_PER_E**2))), 1.0)]
    weight = {
        k: float(np.exp(-drop - NOISE_PRIOR_EXPONENT * (k - best) / NOISE_STEPS_PER_E))
        for k, drop in sorted(fall.items())
    }
    return [(noise_of(k), w / sum(weight.values())) for k, w in weight.items()]


MIN_WHITE_NOISE = 0.35  # counts per sqrt(sample) above which the remainder is white: its harmonic is e^-2(pi s)^2
WHITE_LAG_SAMPLES = 16  # samples


def white_count_noise(dwells: Sequence[IntArray]) -> float:
    """Return the noise [counts/sqrt(sample)] if it is large enough to make the remainder white, else 0.

    Half the mean square of the increments' differences is s^2 + 3/12. A rate near a simple fraction imitates that,
    but not over `WHITE_LAG_SAMPLES` samples, nor does it change an increment by more than 2. ``dwells`` are
    increments (n,) of each dwell, counts per sample.
    """
    fast = _mean_square([np.diff(d) for d in dwells]) / 2 - 0.25
    long = [np.diff(lag_sums(d)) for d in dwells if len(d) > 2 * WHITE_LAG_SAMPLES]
    if not long:
        beyond = max(int(np.abs(np.diff(d)).max(initial=0)) for d in dwells) > 2
        return float(np.sqrt(fast)) if beyond else 0.0
    slow = (_mean_square(long) - 0.5) / (2 * WHITE_LAG_SAMPLES)
    if slow < MIN_WHITE_NOISE**2:
        return 0.0
    return float(np.sqrt(fast if fast > MIN_WHITE_NOISE**2 else slow))  # slow alone: a step, as from a shock


def lag_sums(increments: Samples) -> Samples:
    """Return the sums (m,) of each `WHITE_LAG_SAMPLES` of ``increments`` (n,) [count]."""
    whole = len(increments) // WHITE_LAG_SAMPLES
    sums: Samples = increments[: whole * WHITE_LAG_SAMPLES].reshape(-1, WHITE_LAG_SAMPLES).sum(axis=1)
    return sums


def _mean_square(parts: Sequence[IntArray]) -> float:
    return float(sum(np.sum(part**2.0) for part in parts) / sum(len(part) for part in parts))

"""Recordings of a channel with a planted noise, and what was done to them on the way to the file."""

from collections.abc import Callable

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_records import RateSeries
from procedures.samples.channel_noise import ChannelNoise, noise_of
from procedures.samples.held_samples import held_channel

PERIOD = 0.01
Generator = np.random.Generator
Recording = Callable[[Generator, int], FloatArray]


def analysed(rate: FloatArray, period: float = PERIOD, t: FloatArray | None = None) -> ChannelNoise:
    """Return the noise of a recording ``rate`` (n,), ``period`` [s] apart, or at ``t`` (n,) [s]."""
    n = len(rate)
    t = period * np.arange(1, n + 1) if t is None else t
    gyro = np.stack((rate, np.zeros(n), np.zeros(n)), axis=1)
    series = RateSeries(t, gyro, None, np.full(n, np.nan), float(np.diff(t).mean()))
    return noise_of(held_channel(series, "soak", "gyroscope", 0, 1.0), False)


def names(found: ChannelNoise) -> list[str]:
    return [each.name for each in found.conditions]


def holds(found: ChannelNoise, term: str, truth: float, margin: float = 1.0) -> bool:
    """Say whether a term is not determined, bounded above the truth, or has the truth in its interval."""
    got = found.fit.terms[term]
    if got.value is None:
        return truth <= got.high * margin
    return got.low / margin <= truth <= got.high * margin


def white(rng: Generator, n: int) -> FloatArray:
    return rng.normal(size=n)


def flicker(rng: Generator, n: int) -> FloatArray:
    """Noise of spectrum 1 / (2 pi f): white through half an integrator (Kasdin, Proc. IEEE 1995)."""
    h = np.concatenate(([1.0], np.cumprod((np.arange(1, n) - 0.5) / np.arange(1, n))))
    return np.asarray(np.fft.irfft(np.fft.rfft(h, 2 * n) * np.fft.rfft(rng.normal(size=n), 2 * n), 2 * n)[:n])

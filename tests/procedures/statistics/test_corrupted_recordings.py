"""Recordings that are no sensor's noise: each is named, and no interval leaves out the planted random walk."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from procedures.arrays import FloatArray
from tests.procedures.statistics.recordings_with_a_truth import PERIOD, analysed, holds, names

N = 6000
Rng = np.random.Generator
WALK = np.sqrt(PERIOD)  # of white noise of 1 at 100 Hz


def held(hold: float, step: float = 0.0) -> Callable[[Rng], FloatArray]:
    """Return samples of 1 sigma, each of which the logger writes ``hold`` times."""

    def make(rng: Rng) -> FloatArray:
        sensor = rng.normal(size=N)
        sensor = np.round(sensor / step) * step if step else sensor
        return sensor[(np.arange(N) / hold + rng.uniform()).astype(int)]

    return make


def interpolated(factor: float, decimals: int = 12) -> Callable[[Rng], FloatArray]:
    def make(rng: Rng) -> FloatArray:
        return np.round(np.interp(np.arange(N) / factor, np.arange(N), rng.normal(size=N)), decimals)

    return make


def low_pass(order: int, share: float) -> Callable[[Rng], FloatArray]:
    """Return white noise behind a digital Butterworth filter with its corner at a share of half the rate."""
    return lambda rng: np.asarray(lfilter(*butter(order, share), rng.normal(size=N)))


def rounded(std: float, bias: float, slope: float = 0.0, rows: int = N) -> Callable[[Rng], FloatArray]:
    """Return noise of ``std`` steps about a bias that drifts by ``slope`` steps in all, rounded."""
    return lambda rng: np.round(std * rng.normal(size=rows) + bias + slope * np.arange(rows) / rows)


def in_turn(*devices: tuple[float, float]) -> Callable[[Rng], FloatArray]:
    """Return rows of devices in turn, each of a bias and a noise."""

    def make(rng: Rng) -> FloatArray:
        bias, std = (np.array(each)[np.arange(N) % len(devices)] for each in zip(*devices, strict=True))
        return bias + std * rng.normal(size=N)

    return make


def changed(change: Callable[[FloatArray, Rng], None], bias: float = 0.0) -> Callable[[Rng], FloatArray]:
    def make(rng: Rng) -> FloatArray:
        rate = bias + rng.normal(size=N)
        change(rate, rng)
        return rate

    return make


def copy_block(rate: FloatArray, rng: Rng) -> None:
    rate[3000:3200] = rate[2800:3000]


def copy_every_block(rate: FloatArray, rng: Rng) -> None:
    blocks = rate.reshape(-1, 100)
    blocks[1::2] = blocks[::2]


def zero_fill(rate: FloatArray, rng: Rng) -> None:
    rate[1000:1100] = 0.0


def zero_fill_often(rate: FloatArray, rng: Rng) -> None:
    for i in range(0, N, 500):
        rate[i + 200 : i + 250] = 0.0


def freeze(rate: FloatArray, rng: Rng) -> None:
    rate[4000:4100] = rate[4000]


def spike(rate: FloatArray, rng: Rng) -> None:
    rate[rng.choice(N, 12, replace=False)] += rng.choice([-1, 1], 12) * rng.uniform(20, 1000, 12)


def bump(rate: FloatArray, rng: Rng) -> None:
    rate[1500:1600] += 40 * np.sin(np.arange(100) / 3)


def shift(rate: FloatArray, rng: Rng) -> None:
    rate[2000:] += 60.0


def clip(rate: FloatArray, rng: Rng) -> None:
    np.clip(rate, -9, 2.0, out=rate)


def clip_both(rate: FloatArray, rng: Rng) -> None:
    np.clip(rate, -1, 1, out=rate)


def repeat_now_and_then(rate: FloatArray, rng: Rng) -> None:
    for i in np.flatnonzero(rng.random(N) < 0.2):
        rate[i] = rate[i - 1]


def unsigned(rate: FloatArray, rng: Rng) -> None:
    np.copyto(rate, np.round(6 * rate) % 65536)


def overflow(rate: FloatArray, rng: Rng) -> None:
    np.copyto(rate, (np.round(6 * rate + 120) + 128) % 256 - 128)


def shake(rate: FloatArray, rng: Rng) -> None:
    rate += 20 * lfilter(*butter(2, [0.3, 0.32], "band"), rng.normal(size=N))


CORRUPTED: dict[str, tuple[str, Callable[[Rng], FloatArray], float]] = {
    # name: the condition, the recording, its random walk
    "held 10 times": ("held_samples", held(10), WALK * np.sqrt(10)),
    "held 7 or 8 times": ("held_samples", held(7.4), WALK * np.sqrt(7.4)),
    "held once or twice": ("held_samples", held(1.5), WALK * np.sqrt(1.5)),
    "held twice, in steps as large as the noise": ("held_samples", held(2, 1.0), WALK * np.sqrt(2)),
    "held 5 times, in steps": ("held_samples", held(5, 0.3), WALK * np.sqrt(5)),
    "held 5 times, in large steps": ("held_samples", held(5, 1.4), WALK * np.sqrt(5)),
    "a read that fails now and then": ("repeated_rows", changed(repeat_now_and_then), WALK),
    "interpolated by 4": ("interpolated", interpolated(4), 2 * WALK),
    "interpolated by 10, printed": ("interpolated", interpolated(10, 3), WALK * np.sqrt(10)),
    "interpolated by 2.5": ("interpolated", interpolated(2.5), WALK * np.sqrt(2.5)),
    "interpolated by 1.3": ("filtered", interpolated(1.3), WALK * np.sqrt(1.3)),
    "low pass of first order": ("filtered", low_pass(1, 0.1), WALK),
    "low pass at 0.1": ("filtered", low_pass(2, 0.1), WALK),
    "low pass at 0.5": ("filtered", low_pass(4, 0.5), WALK),
    "mean of 4": ("filtered", lambda rng: np.convolve(rng.normal(size=N), np.ones(4) / 4, "valid"), WALK),
    "0.15 steps": ("coarse_levels", rounded(0.15, 0.0), 0.15 * WALK),
    "0.18 steps, 2400 rows": ("coarse_levels", rounded(0.18, 0.0, rows=2400), 0.18 * WALK),
    "0.15 steps, bias 0.3": ("coarse_levels", rounded(0.15, 0.3), 0.15 * WALK),
    "0.15 steps on an edge": ("coarse_levels", rounded(0.15, 0.5), 0.15 * WALK),
    "0.3 steps": ("coarse_levels", rounded(0.3, 0.2), 0.3 * WALK),
    "0.45 steps": ("coarse_levels", rounded(0.45, 0.1), 0.45 * WALK),
    "0.15 steps, drifting": ("coarse_levels", rounded(0.15, 0.0, 3.0), 0.15 * WALK),
    "0.05 steps, drifting": ("coarse_levels", rounded(0.05, 0.0, 3.0), 0.05 * WALK),
    "0.15 steps, drifting fast": ("coarse_levels", rounded(0.15, 0.0, 200.0), 0.15 * WALK),
    "two devices": ("interleaved", in_turn((0.0, 1.0), (0.8, 1.0)), WALK),
    "two devices far apart": ("interleaved", in_turn((0.0, 1.0), (50.0, 1.0)), WALK),
    "two devices of other noise": ("interleaved", in_turn((0.0, 1.0), (0.0, 2.0)), WALK),
    "three devices": ("interleaved", in_turn((0.0, 1.0), (0.5, 1.0), (-0.4, 1.0)), WALK),
    "four devices": ("interleaved", in_turn((0.0, 1.0), (0.9, 1.0), (-0.9, 1.0), (0.3, 1.0)), WALK),
    "a block twice": ("duplicated_rows", changed(copy_block), WALK),
    "every block twice": ("duplicated_rows", changed(copy_every_block), WALK),
    "a gap of zeros": ("frozen_rows", changed(zero_fill, 5.0), WALK),
    "many gaps of zeros": ("frozen_rows", changed(zero_fill_often, 5.0), WALK),
    "frozen for a second": ("frozen_rows", changed(freeze), WALK),
    "spikes": ("outliers", changed(spike), WALK),
    "a bump": ("outliers", changed(bump), WALK),
    "a shift": ("jumps", changed(shift), WALK),
    "clipped": ("clipped", changed(clip), WALK),
    "clipped on both sides": ("clipped", changed(clip_both), WALK),
    "signed read as unsigned": ("jumps", changed(unsigned), 6 * WALK),
    "overflow of a byte": ("jumps", changed(overflow), 6 * WALK),
    "vibration of a band": ("vibration", changed(shake), WALK),
}  # fmt: skip


@pytest.mark.parametrize("kind", CORRUPTED)
def test_a_corrupted_recording_is_named_and_its_random_walk_within_what_is_stated(kind: str) -> None:
    name, make, walk = CORRUPTED[kind]
    missed = list[object]()
    for seed in range(3):
        found = analysed(make(np.random.default_rng(seed)))
        assert name in names(found), names(found)
        if not holds(found, "random_walk", walk, margin=1.02):  # of 3 at 95 % one may miss
            missed.append(found.fit.terms["random_walk"])
    assert len(missed) <= 1, missed


@pytest.mark.parametrize(("std", "bias"), [(0.15, 0.0), (0.15, 0.3), (0.15, 0.5), (0.05, 0.45)])
def test_noise_below_a_step_is_bounded_by_about_a_third_of_it(std: float, bias: float) -> None:
    for seed in range(5):
        term = analysed(rounded(std, bias)(np.random.default_rng(seed))).fit.terms["random_walk"]
        assert std * WALK <= term.high <= 0.35 * WALK


def test_levels_give_the_noise_below_a_step_within_its_interval() -> None:
    inside = 0
    for seed in range(40):
        std, bias = 0.2 + 0.3 * (seed % 4) / 3, seed / 40
        found = analysed(rounded(std, bias, rows=1500)(np.random.default_rng(seed)))
        term = found.fit.terms["random_walk"]
        inside += holds(found, "random_walk", std * WALK)
        assert term.value is None or term.high / term.low < 4
    assert inside >= 35  # of 40 at 95 %: 34 or less once in 300


def test_a_sine_of_vibration_is_no_quantisation() -> None:
    t = PERIOD * np.arange(20_000)
    rng = np.random.default_rng(2)
    phase = np.cumsum(rng.normal(size=len(t))) * 0.05  # a fan: the line is some tenths of a hertz wide
    found = analysed(rng.normal(size=len(t)) * 0.02 + np.sin(2 * np.pi * 31.7 * t + phase))
    assert found.fit.terms["quantisation"].value is None
    assert "vibration" in names(found)

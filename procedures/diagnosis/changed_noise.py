"""Noise that is another from some moment on: told with the moment; nothing is cut out.

Of every channel the logarithms of the variances of blocks, by the middle half of their samples, are split in two
where their means differ most, by their scatter within the two.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.diagnosis.disturbances import CHANNEL_LABELS, EFFECT, rough_scale
from procedures.diagnosis.disturbed_blocks import MIN_FINE, middle_half, rounding_of
from procedures.diagnosis.result import Finding
from procedures.frames import TRIADS

BLOCK_S, MIN_BLOCK = 10.0, 48  # s, samples
MIN_BLOCKS, LEAST_SIDE = 20, 5
MIN_TIMES = 1.5  # by which the noise must be larger, or less
TINY = 1e-12
MIN_SIGMAS = 8.0  # of the difference of the means


def changed_noise(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each triad of a recording at rest whose noise changes for good."""
    for campaign in campaigns:
        for rest in campaign.rests:
            for triad in TRIADS:
                if (samples := channel(rest.series, triad)) is not None:
                    yield from _of_triad(campaign, rest, triad, np.asarray(samples, dtype=np.float64))


def _of_triad(campaign: Campaign, rest: RestRecord, triad: str, samples: FloatArray) -> Iterator[Finding]:
    length = max(round(BLOCK_S / rest.series.period), MIN_BLOCK)
    found = [(*each, axis) for axis in range(3) if (each := _split(samples[:, axis], length)) is not None]
    if not found:
        return
    sigmas, at, before, after, axis = max(found)
    k = float(rough_scale(campaign, triad)[axis]) * (rest.series.period if campaign.counts else 1.0)
    names = [CHANNEL_LABELS[triad][each[-1]] for each in found]
    where: dict[str, object] = {
        "file": rest.name, "channel": names if len(names) > 1 else names[0], "from_s": float(rest.series.t[at]),
    }  # fmt: skip
    std = np.hypot(before, after) / np.sqrt(2 * length * MIN_BLOCKS) / abs(k)
    yield Finding(
        EFFECT, "procedure", ("value",), np.array([(after - before) / abs(k)]), np.array([std]),
        "g" if triad == "accelerometer" else "deg/h", where, "ambiguous", (f"{triad}.noise",),
        "the recording again, elsewhere and at another temperature", -(sigmas**2) / 2, 0.0,
        f"noise of a sample, {after / before:.2g} times what it was",
    )  # fmt: skip


def _split(x: FloatArray, length: int) -> tuple[float, int, float, float] | None:
    """Return by how many sigmas noise differs, the sample from which on, and a sample's before and after."""
    count = len(x) // length
    if count < MIN_BLOCKS:
        return None
    variance = middle_half(x[: count * length].reshape(count, length))
    if not np.all(variance > 0) or float(np.median(variance)) < MIN_FINE * rounding_of([x]):
        return None
    v = np.log(variance)
    k = np.arange(LEAST_SIDE, count - LEAST_SIDE + 1)
    sums = np.cumsum(v)
    first, last = sums[k - 1] / k, (sums[-1] - sums[k - 1]) / (count - k)
    within = np.maximum(np.sum(v**2) - k * first**2 - (count - k) * last**2, 0.0) / (count - 2)
    sigmas = np.abs(last - first) / np.sqrt(np.maximum(within, TINY) * (1 / k + 1 / (count - k)))
    best = int(np.argmax(sigmas))
    if sigmas[best] < MIN_SIGMAS or abs(last[best] - first[best]) < 2 * np.log(MIN_TIMES):
        return None
    before, after = np.exp(first[best] / 2), np.exp(last[best] / 2)
    return float(sigmas[best]), int(k[best]) * length, float(before), float(after)

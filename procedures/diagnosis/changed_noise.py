"""Noise that is another from some moment on: told with the moment; nothing is cut out.

Of every channel the logarithms of the variances of blocks, by the middle half of their samples, are split in two
where their means differ most, by their scatter within the two.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.disturbances import EFFECT
from procedures.diagnosis.disturbed_blocks import MIN_FINE, middle_half, rounding_of
from procedures.diagnosis.resting_channels import RestingChannel, resting_channels
from procedures.diagnosis.result import Finding
from procedures.statistics.significance import log_f_sf

BLOCK_S, MIN_BLOCK = 10.0, 48  # s, samples
MIN_BLOCKS, LEAST_SIDE = 20, 5
MIN_TIMES = 1.5  # by which the noise must be larger, or less
TINY = 1e-12
MIN_SIGMAS = 8.0  # of the difference of the means


def changed_noise(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each triad of a recording at rest whose noise changes for good."""
    for _, channels in groupby(resting_channels(campaigns), key=lambda one: (one.campaign, one.step, one.triad)):
        found = list[tuple[float, RestingChannel, int, float, float, float]]()
        for one in channels:
            length = max(round(BLOCK_S / one.rest.series.period), MIN_BLOCK)
            if (split := _split(one.samples, length)) is not None:
                found.append((split[0], one, *split[1:]))
        if found:
            yield _finding(max(found, key=lambda each: each[0]), [each[1].label for each in found])


def _finding(found: tuple[float, RestingChannel, int, float, float, float], names: Sequence[str]) -> Finding:
    sigmas, one, at, before, after, log_p = found
    where: dict[str, object] = {
        "file": one.rest.name, "channel": list(names) if len(names) > 1 else names[0],
        "from_s": float(one.rest.series.t[at]),
    }  # fmt: skip
    value = np.array([after - before]) / one.per_unit
    return Finding(
        EFFECT, "procedure", ("value",), value, np.abs(value) / sigmas, one.unit, where, "ambiguous",
        (f"{one.triad}.noise",), "the recording again, elsewhere and at another temperature", log_p,
        0.0, f"noise of a sample, {after / before:.2g} times what it was",
    )  # fmt: skip


def _split(x: FloatArray, length: int) -> tuple[float, int, float, float, float] | None:
    """Return by how many sigmas noise differs, from which sample on, a sample's before and after, and ln p.

    p is of Student's t of the blocks, every place of a change counted.
    """
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
    log_p = min(log_f_sf(float(sigmas[best]) ** 2, 1, count - 2) + float(np.log(len(k))), 0.0)
    return float(sigmas[best]), int(k[best]) * length, float(before), float(after), log_p

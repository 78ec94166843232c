"""Rows that do not belong together: of several devices in turn, of two ranges, copied, at an end of the range.

Rows of p devices in turn differ with period p, in their mean or their noise: a line at exactly k/p of the sample
rate in the samples or in their absolute values, whose power over that of its neighbours is exponentially
distributed in noise (`procedures.statistics.spectrum`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft
from scipy.special import betainc

from procedures.arrays import BoolArray, FloatArray, IntArray, true_runs
from procedures.statistics.noise_conditions import ALL, MAX_LOG_P, Condition
from procedures.statistics.significance import robust_std
from procedures.statistics.spectrum import MEDIAN_OF_EXPONENTIAL, hann, without_straight_line

DEVICES = (2, 3, 4)  # that one file may hold
COMMON_MULTIPLE = 12  # of them
MOST_ROWS = 12 * 2**15  # in which a pattern of rows is looked for
NEIGHBOURS = 100  # frequencies whose median is the background, on either side
BLOCK = 256  # rows, whose median is the level
OUTLIER_SIGMAS = 8.0  # robust sigmas: once in 1e15 of Gaussian noise
TAIL_SHARES, TAIL_CHANCE = (0.2, 0.05), 1e-3  # which show how fast the tails fall; of one outlier in a recording
MAX_OUTLIER_SHARE = 0.01  # of the rows, replaced; of more it is no outlier
FAR = 30.0  # noise from row to row, between two ranges of values
NEAR_SHARE, NEAR_SIGMAS = 0.1, 0.1257  # of the differences; that quantile of absolute Gaussian ones
MIN_ROWS = 3  # in each of them, and in sequence: others are outliers
CLIP_TIMES, MIN_CLIPPED, CLIP_SHARE = 5.0, 10, 5e-4  # as often as the values next to it; rows; of all rows
MAX_WINDOW = 64  # rows that are compared for copies
COPY_BITS = 24.0  # of entropy, beyond that of all pairs of rows: once in 2^24 recordings
MIN_COPIED = 16  # rows


@dataclass(frozen=True, slots=True, eq=False)
class BadRows:
    """Rows (n,) that ``mask`` marks, and the condition that they are."""

    mask: BoolArray
    condition: Condition


def interleaved_rows(rate: FloatArray) -> Condition | None:
    """Return the condition that rows of ``rate`` (n,) in any unit differ with a period of 2 to 4 rows."""
    n = min(len(rate), MOST_ROWS) // COMMON_MULTIPLE * COMMON_MULTIPLE
    if n < 4 * NEIGHBOURS:
        return None
    level = without_straight_line(rate[:n])
    noise = np.abs(level - np.repeat(_block_medians(level), _block_sizes(n)))
    powers = [("mean", _power(level)), ("noise", _power(noise))]
    found = [(p, what) for what, power in powers for p in DEVICES if _log_p_of_period(power, n, p) < MAX_LOG_P]
    if not found:
        return None
    p, what = found[0]
    sizes = [float(np.mean(rows) if what == "mean" else np.std(rows)) for rows in (rate[i:n:p] for i in range(p))]
    text = (
        f"Every {_ORDINALS[p]} row differs from the others in its {what}: rows of {p} devices in one file, or a "
        f"disturbance at exactly 1/{p} of the sample rate. Separate the rows by device."
    )
    values = {"devices": float(p), "low": min(sizes), "high": max(sizes)}
    return Condition("interleaved", text, ALL, values, is_of_recording=True)


_ORDINALS = {2: "second", 3: "third", 4: "fourth"}


def _power(x: FloatArray) -> FloatArray:
    return np.abs(rfft((x - x.mean()) * hann(len(x)))) ** 2


def _log_p_of_period(power: FloatArray, n: int, p: int) -> float:
    """Return ln of the chance that noise of spectrum ``power`` repeats so much every ``p`` of its ``n`` rows.

    All harmonics must be there.
    """
    worst = -np.inf
    for k in range(1, p // 2 + 1):
        at = k * n // p
        near = np.concatenate([power[max(at - NEIGHBOURS, 1) : at - 3], power[at + 4 : at + NEIGHBOURS]])
        background = float(np.median(near)) / MEDIAN_OF_EXPONENTIAL
        if background <= 0:
            return 0.0 if power[at] <= 0 else -np.inf
        dof, peak = (1, power[at] / 2) if 2 * at == n else (2, power[at])  # at Nyquist one square
        m = len(near)  # Fisher's F of a mean square over another
        chance = float(betainc(m / 2, dof / 2, m / (m + dof * peak / background)))
        worst = max(worst, float(np.log(max(chance, 1e-300))))
    return worst


def outlying_rows(rate: FloatArray, step: float) -> BadRows | None:
    """Return rows of ``rate`` (n,) far from the others near them; ``step`` is the `level_step`, in its unit."""
    off = rate - _running_level(rate)
    sigma = max(robust_std(off), step / 2)
    near, far = np.quantile(np.abs(off), [1 - share for share in TAIL_SHARES])
    decay = (far - near) / np.log(TAIL_SHARES[0] / TAIL_SHARES[1])  # of an exponential tail
    tail = far + decay * np.log(TAIL_SHARES[1] * len(rate) / TAIL_CHANCE)
    mask: BoolArray = np.abs(off) > max(OUTLIER_SIGMAS * sigma, tail)
    count = int(mask.sum())
    if not count:
        return None
    worst = float(np.abs(off).max() / sigma)
    text = f"{count} of {len(rate)} rows lie far from the others, the worst by {worst:.3g} sigma."
    return BadRows(mask, Condition("outliers", text, (), {"rows": float(count), "sigmas": worst}))


def two_ranges(rate: FloatArray, step: float) -> BadRows | None:
    """Return the rows of ``rate`` (n,) in the smaller of two ranges of values far from each other.

    ``step`` is the `level_step` in its unit. The condition leaves all undetermined where rows jump to and fro.
    """
    near = float(np.quantile(np.abs(np.diff(rate)), NEAR_SHARE))  # of rows in one range, even if half of them jump
    noise = max(near / (np.sqrt(2) * NEAR_SIGMAS), step)
    ordered = np.sort(rate)
    at = int(np.argmax(np.diff(ordered)))
    gap = float(ordered[at + 1] - ordered[at])
    if gap < FAR * noise or min(at + 1, len(rate) - at - 1) < MIN_ROWS:
        return None
    upper = rate > ordered[at]
    smaller = upper if upper.sum() <= len(rate) / 2 else ~upper
    if int(np.ptp(true_runs(smaller), axis=1).max()) <= MIN_ROWS and smaller.mean() <= MAX_OUTLIER_SHARE:
        return None
    jumps = int(np.sum(upper[1:] != upper[:-1]))
    often = jumps > 2 and smaller.mean() > MAX_OUTLIER_SHARE
    text = (
        f"Values jump {jumps} times between {ordered[0]:.6g} to {ordered[at]:.6g} and {ordered[at + 1]:.6g} to "
        f"{ordered[-1]:.6g}: an overflow, an unsigned number that should be signed, two devices, or a shift."
    )
    values = {"jumps": float(jumps), "gap": gap}
    return BadRows(smaller, Condition("jumps", text, ALL if often else (), values))


def clipped_rows(rate: FloatArray, step: float) -> Condition | None:
    """Return that ``rate`` (n,) stands at one end of its values; ``step`` is the `level_step`, in its unit."""
    for end, name in ((rate.max(), "largest"), (rate.min(), "smallest")):
        rows = int(np.sum(rate == end))
        off = np.abs(rate - end)
        neighbours = int(np.sum((off > 0) & (off < 3.5 * step))) / 3
        if rows >= max(MIN_CLIPPED, CLIP_SHARE * len(rate)) and rows > CLIP_TIMES * (neighbours + 1):
            share = rows / len(rate)
            text = f"{100 * share:.3g} % of the rows stand at the {name} value: the output is clipped there."
            return Condition("clipped", text, ALL, {"share": share, "value": float(end)})
    return None


def copied_rows(rate: FloatArray) -> BadRows | None:
    """Return rows of ``rate`` (n,), any unit, that are a copy of earlier ones, longer than chance makes it."""
    n = len(rate)
    change = np.diff(rate)
    _, label, often = np.unique(change, return_inverse=True, return_counts=True)
    entropy = -float(np.log2(np.sum((often / len(change)) ** 2))) - 0.5  # neighbouring differences hang together
    if entropy <= 0:
        return None
    window = int(np.ceil((2 * np.log2(n) + COPY_BITS) / entropy))
    window = max(window, MIN_COPIED)
    if window > MAX_WINDOW or len(change) < 2 * window:
        return None
    words = np.random.default_rng(0).integers(1, 2**63, size=window, dtype=np.uint64) | np.uint64(1)
    key = label.astype(np.uint64) + np.uint64(1)
    total = np.zeros(len(change) - window + 1, dtype=np.uint64)
    for i in range(window):
        total += key[i : i + len(total)] * words[i]
    order = np.argsort(total, kind="stable")
    same = np.flatnonzero(total[order][1:] == total[order][:-1])
    if not len(same):
        return None
    first, second = order[same], order[same + 1]
    mask = _copies(first, second, window, n)
    if not mask.any():
        return None
    count, begin = int(mask.sum()), int(np.argmax(mask))
    source = begin - int((second - first)[np.argmin(second)])
    text = f"{count} rows are copies of earlier ones, the first of them row {begin + 1}, as row {source + 1}."
    return BadRows(mask, Condition("duplicated_rows", text, (), {"rows": float(count), "first": float(begin)}))


def _copies(first: IntArray, second: IntArray, window: int, n: int) -> BoolArray:
    edges = np.zeros(n + 1, dtype=np.int64)
    np.add.at(edges, second, 1)
    np.add.at(edges, np.minimum(second + window + 1, n), -1)
    return np.cumsum(edges[:n]) > 0


def _block_sizes(n: int) -> IntArray:
    blocks = max(n // BLOCK, 1)
    return n // blocks + (np.arange(blocks) < n % blocks).astype(np.int64)


def _block_medians(x: FloatArray) -> FloatArray:
    sizes = _block_sizes(len(x))  # the first ones may be longer by one
    long = int(np.sum(sizes > sizes[-1]))
    parts = (x[: long * sizes[0]].reshape(long, int(sizes[0])), x[long * sizes[0] :].reshape(-1, int(sizes[-1])))
    return np.concatenate([np.median(part, axis=1) for part in parts if len(part)])


def _running_level(x: FloatArray) -> FloatArray:
    """Return the level of x (n,): medians of blocks, straight in between."""
    medians, sizes = _block_medians(x), _block_sizes(len(x))
    middles = np.cumsum(sizes) - (sizes + 1) / 2
    rows = np.arange(len(x))
    level: FloatArray = np.interp(rows, middles, medians)
    if len(medians) > 1:  # straight on beyond the middles of the first and the last
        slopes = np.diff(medians) / np.diff(middles)
        level += np.minimum(rows - middles[0], 0) * slopes[0] + np.maximum(rows - middles[-1], 0) * slopes[-1]
    return level

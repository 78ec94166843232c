"""Where the range of a gyroscope ends on a rate table: the output stays as it is while the table turns faster.

Beyond the end an output says nothing of scale factor, bias or any other effect: these points are left out. The
scale factor within the range is that of the points whose output is away from both ends. IEEE Std 952, input rate
limits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign, RateTable
from procedures.frames import AXES
from procedures.inference.result import CERTAIN, Finding
from procedures.statistics.significance import STD_PER_MAD

EFFECT = "gyroscope.saturation"
INSIDE = 0.05  # of the range of outputs, by which a point within it is away from both ends
MIN_INSIDE, MIN_BEYOND = 5, 2  # points within the range, rates beyond one end of it
MIN_SHORT = 0.01  # of the range of outputs, by which an output beyond the end is too small
MIN_SHORT_SIGMAS = 5.0  # the same, of the points' scatter about a line within the range
FLAT = 0.1  # of the scale factor, by which at the most an output beyond the end still follows, at 2 sigma
NEAR_SIGMAS = 4.0  # of the end, within which a point may be cut off by noise


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """An end of the range: the ``rows`` (n,) beyond it, the rate there [deg/s] with 1 sigma."""

    rows: BoolArray
    rate: float
    std: float


def without_saturated(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[Finding, ...]]:
    """Return campaigns whose rate tables lack outputs beyond the ends of a range; a finding for each sensor."""
    findings, kept = list[Finding](), list[Campaign]()
    for campaign in campaigns:
        tables = list[RateTable]()
        for table in campaign.rate_tables:
            output = table.output.copy()
            for sensor in range(len(AXES)):
                if ends := _ends(table.reference, table.output[:, sensor]):
                    output[np.any([end.rows for end in ends], axis=0), sensor] = np.nan
                    findings.append(_finding(table, sensor, ends))
            tables.append(replace(table, output=output))
        kept.append(replace(campaign, rate_tables=tuple(tables)))
    return tuple(kept), tuple(findings)


def _ends(reference: FloatArray, output: FloatArray) -> list[_End]:
    """Return the ends of the range that outputs (n,) at the rates ``reference`` (n,) [deg/s] show."""
    known = np.isfinite(output)
    if known.sum() < MIN_INSIDE + MIN_BEYOND:
        return []
    low, high = float(output[known].min()), float(output[known].max())
    away = INSIDE * (high - low)
    inside = known & (output > low + away) & (output < high - away)
    if inside.sum() < MIN_INSIDE or np.ptp(reference[inside]) == 0:
        return []
    A = np.column_stack((reference[inside], np.ones(inside.sum())))
    (k, b), *_ = np.linalg.lstsq(A, output[inside])
    left = output[inside] - A @ (k, b)
    sigma = STD_PER_MAD * float(np.median(np.abs(left - np.median(left))))
    least = max(MIN_SHORT * (high - low), MIN_SHORT_SIGMAS * sigma)
    predicted, found = k * reference + b, list[_End]()
    for side, extreme in ((1.0, high), (-1.0, low)):
        beyond = known & (side * (predicted - extreme) > least)
        if len(np.unique(reference[beyond])) < MIN_BEYOND or not _is_flat(predicted[beyond], output[beyond]):
            continue
        level, scatter = float(np.mean(output[beyond])), float(np.std(output[beyond]))
        rows = known & (side * (predicted - level) > -NEAR_SIGMAS * max(scatter, sigma))
        of_side = known & ~rows & (side * (output - b) > 0)
        fitted = of_side if of_side.sum() >= MIN_INSIDE else inside
        rate, std = _rate_at(level, reference[fitted], output[fitted])
        found.append(_End(rows, rate, float(np.hypot(std, scatter / k / np.sqrt(beyond.sum())))))
    return sorted(found, key=lambda end: -end.rate)


def _rate_at(level: float, reference: FloatArray, output: FloatArray) -> tuple[float, float]:
    """Return the rate [deg/s] with 1 sigma at which outputs (n,) of one side come to ``level``, by a parabola."""
    x = (output - level) / np.ptp(output)
    A = np.vander(x, min(3, len(np.unique(reference))), increasing=True)
    c, *_ = np.linalg.lstsq(A, reference)
    left = reference - A @ c
    variance = float(left @ left) / max(len(left) - A.shape[1], 1)
    return float(c[0]), float(np.sqrt(variance * np.linalg.pinv(A.T @ A)[0, 0]))


def _is_flat(predicted: FloatArray, output: FloatArray) -> bool:
    """Say whether outputs (n,) stay as they are where a line goes on to ``predicted`` (n,)."""
    x = predicted - predicted.mean()
    slope = float(x @ output / (x @ x))
    left = output - output.mean() - slope * x
    std = float(np.sqrt(left @ left / max(len(x) - 2, 1) / (x @ x)))
    return abs(slope) + 2 * std < FLAT


def _finding(table: RateTable, sensor: int, ends: Sequence[_End]) -> Finding:
    axis, left_out = AXES[sensor], int(np.sum(np.any([end.rows for end in ends], axis=0)))
    names = tuple(f"{axis}{'+' if end.rate > 0 else '-'}" for end in ends)
    return Finding(
        EFFECT, "instrument", names, np.array([end.rate for end in ends]), np.array([end.std for end in ends]),
        "deg/s", {"file": table.name}, CERTAIN, "nothing: the rates within the range are used",
        f"{left_out} of {len(table.reference)} points lie beyond the end of the range and are left out",
    )  # fmt: skip

"""``clock.rate``: the device's clock against reference time, and the sample period against the stated one.

Positive is fast: while the reference moves by dt, device time moves by ``(1 + 1e-6 c) dt``. Every rate computed
with device time is too small by as much. Where rows hold reference time (``utc_s``), it is fitted by a line over
device time: of block means, so that a coarse or jittery reference counts for no more than it tells, and robustly,
so that a step of the reference in some blocks does not. Without it, a sample period in device time that is not the
stated one says that either the clock or the statement is wrong, and cannot say which.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign import Campaign, DwellRecord, RestRecord, SequenceRecord, TurnRecord
from procedures.diagnosis.result import Confidence, Finding, Test
from procedures.diagnosis.tail import log_f_sf
from procedures.effects import EFFECTS
from procedures.records import Series

EFFECT = "clock.rate"
PPM = 1e6
BLOCKS = 64  # of a campaign's rows
LEAST = 6  # blocks, of which two go to the line
OUTLIER = 5.0  # robust sigmas
OFF_PERIOD = 1e-3  # relative, as the warning of DESIGN 5
ESTABLISHED, LIKELY = np.log(0.01), np.log(0.05)
PLAUSIBLE = 5e4  # ppm: beyond, utc_s is no time of these rows

Record = TypeVar("Record", DwellRecord, TurnRecord, RestRecord, SequenceRecord)


@dataclass(frozen=True, slots=True)
class ClockRate:
    """How fast the device's clock is [ppm], 1 sigma, and the degrees of freedom behind it."""

    ppm: float
    std: float
    dof: float

    @property
    def log_p(self) -> float:
        """Ln p of a clock that is right."""
        return log_f_sf((self.ppm / self.std) ** 2, 1, self.dof)


def find_clock(campaigns: Sequence[Campaign]) -> tuple[tuple[Finding, ...], tuple[Test, ...]]:
    """Return what one unit's campaigns show of its clock, and the test made."""
    rates = [rate for campaign in campaigns if (rate := clock_rate(campaign)) is not None]
    if not rates:
        return tuple(_off_period(campaigns)), ()
    mean = _mean(rates)
    adjusted = min(mean.log_p + float(np.log(len(EFFECTS))), 0.0)  # Holm: one of all that are tried
    test = Test(EFFECT, (mean.ppm / mean.std) ** 2, mean.log_p, adjusted)
    if adjusted >= LIKELY or abs(mean.ppm) > PLAUSIBLE:
        return (), (test,)
    confidence: Confidence = "established" if adjusted < ESTABLISHED else "likely"
    return (_finding(mean.ppm, mean.std, confidence, adjusted, "utc_s"),), (test,)


def with_true_clock(campaigns: Sequence[Campaign], ppm: float) -> tuple[Campaign, ...]:
    """Return the campaigns with device times and sample periods [s] as a right clock would have given them."""
    return tuple(
        replace(
            campaign,
            dwells=tuple(_slowed(each, ppm) for each in campaign.dwells),
            turns=tuple(_slowed(each, ppm) for each in campaign.turns),
            rests=tuple(_slowed(each, ppm) for each in campaign.rests),
            sequences=tuple(_slowed(each, ppm) for each in campaign.sequences),
        )
        for campaign in campaigns
    )


def is_timed(campaigns: Sequence[Campaign]) -> bool:
    """Say whether reference time tells the clock's rate in any campaign."""
    return any(clock_rate(campaign) is not None for campaign in campaigns)


def clock_rate(campaign: Campaign) -> ClockRate | None:
    """Fit reference time over device time in all rows that hold it; None where too few do."""
    rows = [(s.t, s.extra["utc_s"]) for s in _series(campaign) if "utc_s" in s.extra]
    if not rows:
        return None
    t, utc = (np.concatenate(each) for each in zip(*rows, strict=True))
    return fit_clock(t, utc)


def fit_clock(t: FloatArray, utc: FloatArray) -> ClockRate | None:
    """Fit reference time (n,) over device time (n,) [s], nan where it is not known; None where too few are."""
    known = np.isfinite(utc)
    order = np.argsort(t[known])
    t, utc = t[known][order], utc[known][order]
    if len(t) < 2 * LEAST or not np.ptp(t) > 0:
        return None
    t, utc = t - t[0], utc - utc[0]  # before the means: of seconds since 1970 a float holds a quarter microsecond
    return _line(t, utc - t)


def _line(t: FloatArray, behind: FloatArray) -> ClockRate | None:
    """Fit ``behind`` [s], by which the reference has moved more than device time, over device time ``t`` [s]."""
    blocks = [b for b in np.array_split(np.arange(len(t)), min(BLOCKS, len(t) // 2)) if len(b)]
    x, y = (np.array([each[b].mean() for b in blocks]) for each in (t, behind))
    keep = _inliers(x, y)
    x, y = x[keep], y[keep]
    if len(x) < LEAST:
        return None
    x = x - x.mean()
    slope = float(x @ y / (x @ x))
    left = y - y.mean() - slope * x
    dof = len(x) - 2
    variance = max(float(left @ left) / dof, (4 * np.spacing(np.abs(t).max())) ** 2)
    # x ppm fast: the reference moves by 1 / (1 + 1e-6 x) of what device time does
    ppm = PPM * (1 / (1 + slope) - 1)
    return ClockRate(ppm, float(PPM * np.sqrt(variance / (x @ x))) / (1 + slope) ** 2, float(dof))


def _inliers(x: FloatArray, y: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Mark the points near the line of the median slope between all pairs (Theil and Sen)."""
    i, j = np.triu_indices(len(x), 1)
    slope = np.median((y[j] - y[i]) / np.maximum(x[j] - x[i], np.finfo(float).tiny))
    off = y - slope * x
    off = np.abs(off - np.median(off))
    return np.asarray(off <= OUTLIER * max(1.4826 * float(np.median(off)), np.finfo(float).eps * np.abs(y).max()))


def _mean(rates: Sequence[ClockRate]) -> ClockRate:
    """Return the weighted mean of several campaigns, its sigma widened where they differ by more than theirs."""
    w = np.array([rate.std**-2 for rate in rates])
    values = np.array([rate.ppm for rate in rates])
    mean = float(w @ values / w.sum())
    spread = float(w @ (values - mean) ** 2) / max(len(rates) - 1, 1)
    return ClockRate(mean, float(np.sqrt(max(spread, 1.0) / w.sum())), sum(rate.dof for rate in rates))


def _off_period(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Report a sample period in device time that is not the stated one."""
    off = [s.period / c.nominal_period - 1 for c in campaigns if c.nominal_period is not None for s in _series(c)]
    if off and abs(np.median(off)) > OFF_PERIOD:
        std = float(np.std(off)) if len(off) > 1 else abs(off[0]) * 1e-3
        found = _finding(PPM * float(np.median(off)), PPM * std, "ambiguous", -np.inf, "t_s")
        yield replace(found, aliases=("imu.sample_period_s",), log_p=float(np.log(np.finfo(float).tiny)))


def _finding(ppm: float, std: float, confidence: Confidence, log_p: float, channel: str) -> Finding:
    told = (
        "either the device's clock or sample_period_s is wrong: record a reference time beside the rows (utc_s)"
        if channel == "t_s"
        else "a second campaign with reference time beside the rows (utc_s)"
    )
    return Finding(
        EFFECT, "procedure", ("value",), np.array([ppm]), np.array([std]), "ppm", {"channel": channel}, confidence,
        (), told, log_p, 0.0,
    )  # fmt: skip


def _series(campaign: Campaign) -> Iterator[Series]:
    for records in (campaign.dwells, campaign.turns, campaign.rests, campaign.sequences):
        for record in records:
            yield record.series


def _slowed(record: Record, ppm: float) -> Record:
    series, by = record.series, 1 + ppm / PPM
    return replace(record, series=replace(series, t=series.t / by, period=series.period / by))

"""``clock.rate``: the device's clock against reference time, and the sample period against the stated one.

Positive is fast: while the reference moves by dt, device time moves by ``(1 + 1e-6 c) dt``. Every rate computed
with device time is too small by as much. Where rows hold reference time (``utc_s``), it is fitted by a line over
device time (`procedures.counts.reference_time`). Without it, a sample period in device time that is not the stated
one says that either the clock or the statement is wrong, and cannot say which.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import (
    MAX_CLOCK_PPM,
    Campaign,
    DwellRecord,
    MoveRecord,
    RestRecord,
    SequenceRecord,
    TurnRecord,
    clock_rate,
    is_known,
)
from procedures.counts.reference_time import ClockRate
from procedures.inference import odds
from procedures.inference.result import EffectTest, Finding
from procedures.units import PPM_PER_ONE

EFFECT = "clock.rate"
MAX_PERIOD_ERROR = 1e-3  # relative, as the warning of a campaign folder

Record = TypeVar("Record", DwellRecord, TurnRecord, MoveRecord, RestRecord, SequenceRecord)


def find_clock(campaigns: Sequence[Campaign]) -> tuple[tuple[Finding, ...], tuple[EffectTest, ...]]:
    """Return what one unit's campaigns show of its clock, and the test made."""
    rates = [rate for campaign in campaigns if (rate := clock_rate(campaign)) is not None and is_known(rate)]
    if not rates:
        return tuple(_off_period(campaigns)), ()
    mean = _mean(rates)
    log_odds = _log_odds(mean.ppm / mean.std, mean.dof)
    test = EffectTest(EFFECT, log_odds)
    if log_odds < 0 or abs(mean.ppm) > MAX_CLOCK_PPM:
        return (), (test,)
    return (_finding(mean.ppm, mean.std, log_odds, "utc_s"),), (test,)


def with_true_clock(campaigns: Sequence[Campaign], ppm: float) -> tuple[Campaign, ...]:
    """Return the campaigns with device times and sample periods [s] as a right clock would have given them."""
    return tuple(
        replace(
            campaign,
            dwells=tuple(_slowed(each, ppm) for each in campaign.dwells),
            turns=tuple(_slowed(each, ppm) for each in campaign.turns),
            moves=tuple(_slowed(each, ppm) for each in campaign.moves),
            rests=tuple(_slowed(each, ppm) for each in campaign.rests),
            sequences=tuple(_slowed(each, ppm) for each in campaign.sequences),
        )
        for campaign in campaigns
    )


def is_timed(campaigns: Sequence[Campaign]) -> bool:
    """Say whether reference time tells the clock's rate in any campaign."""
    return any((rate := clock_rate(campaign)) is not None and is_known(rate) for campaign in campaigns)


def _log_odds(sigmas: float, dof: float) -> float:
    """Return ln of the odds of a clock that is off by so many ``sigmas``, which are known to ``dof``."""
    return odds.log_odds(float(odds.gain_of_squares(np.array(sigmas**2), 1, dof)))


def _mean(rates: Sequence[ClockRate]) -> ClockRate:
    """Return the weighted mean of several campaigns, its sigma widened where they differ by more than theirs."""
    w = np.array([rate.std**-2 for rate in rates])
    values = np.array([rate.ppm for rate in rates])
    mean = float(w @ values / w.sum())
    spread = float(w @ (values - mean) ** 2) / max(len(rates) - 1, 1)
    return ClockRate(mean, float(np.sqrt(max(spread, 1.0) / w.sum())), sum(rate.dof for rate in rates))


def _off_period(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Report a sample period in device time that is not the stated one by more than the files scatter."""
    stated = [(c.nominal_period, c.steps) for c in campaigns if c.nominal_period is not None]
    each = [(step.series, nominal) for nominal, steps in stated for step in steps]
    off = [series.period / nominal - 1 for series, nominal in each]
    if not off or abs(middle := float(np.median(off))) <= MAX_PERIOD_ERROR:
        return
    scatter = float(np.std(off, ddof=1)) if len(off) > 1 else 0.0
    std = max(scatter, *(_period_std(series.t) / nominal for series, nominal in each))
    log_odds = _log_odds(middle / std, len(off) - 1 if len(off) > 1 else np.inf)
    if log_odds > 0:
        found = _finding(PPM_PER_ONE * middle, PPM_PER_ONE * std, log_odds, "t_s")
        yield found.or_else("imu.sample_period_s")


def _period_std(t: FloatArray) -> float:
    """Return the standard uncertainty [s] of the sample period by how stamps ``t`` (n,) [s] scatter."""
    rows = np.arange(len(t)) - (len(t) - 1) / 2
    left = t - t.mean() - rows * float(rows @ t) / float(rows @ rows)
    rounding = float(np.spacing(np.abs(t).max()))
    return float(np.hypot(np.std(left), rounding)) / float(np.sqrt(rows @ rows))


def _finding(ppm: float, std: float, log_odds: float, channel: str) -> Finding:
    separate_by = (
        "either the device's clock or sample_period_s is wrong: record a reference time with the rows (utc_s)"
        if channel == "t_s"
        else "a second campaign with a reference time in its rows (utc_s)"
    )
    return Finding(
        EFFECT, "procedure", ("value",), np.array([ppm]), np.array([std]), "ppm", {"channel": channel},
        odds.probability(log_odds), separate_by,
    )  # fmt: skip


def _slowed(record: Record, ppm: float) -> Record:
    series, by = record.series, 1 + ppm / PPM_PER_ONE
    return replace(record, series=replace(series, t=series.t / by, period=series.period / by))

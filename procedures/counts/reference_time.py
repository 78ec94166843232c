"""How fast a device's clock is, from the reference time of its rows.

Reference time of a row is read late by what ports, adapters and a busy machine add, never early, and now and then
at once: so of each stretch of a campaign the least late row counts, and the noise of these is estimated with its
memory (`procedures.statistics.line_fits`). A reference that is latched by a pulse errs to both sides: there the
mean of a stretch determines more. Which it is shows in how well each draws a line. One that is cut to whole
seconds determines the moment at which it goes on, to the distance of two rows; that error may be the same for all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.statistics.line_fits import CorrelatedLine, fit_correlated_line, median_slope
from procedures.statistics.significance import STD_PER_MAD
from procedures.units import PPM_PER_ONE

LINE_BLOCKS, MIN_LINE_BLOCKS = 24, 6  # stretches of all rows, and as few as that are a line
DECIMALS_S = (1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5)  # s, of stamps that were written with few decimals
LEAST_SCATTER = 0.05  # of the last decimal, by which rounding alone scatters six times
MAX_RECORDS_APART = 96  # records, of more each is one block: noises of 600 points take seconds and 0.5 GB
MIN_RECORD_BLOCKS, MIN_BLOCK_ROWS = 2, 2  # of a record, so that it determines a slope; rows of a block
OUTLIER_SIGMAS = 5.0  # robust sigmas
MAX_DELAY_STEPS = 4  # of the delay at the most: a logger that was started again has another one
ENVELOPE_PASSES = 4  # of taking the least late rows by the rate before
LINE_PASSES = 2  # of taking them by the line
MAX_SIGMA_RATIO = 0.7  # of the envelope's sigma: from there on another one counts instead
COARSE_TICK_SHARE = 0.5  # of rows whose reference is another than that of the row before: with fewer it is cut
# s, relative: by more, one clock was set or restarted between two records
MAX_CLOCK_LEAP_S, MAX_CLOCK_DRIFT = 2.0, 0.05

Piece = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class ClockRate:
    """How fast the device's clock is [ppm], 1 sigma, and the degrees of freedom behind it.

    ``delay`` [s] is how late of the line nine of ten rows at most are: of a quiet machine's reading, milliseconds.
    """

    ppm: float
    std: float
    dof: float
    delay: float = 0.0


def fit_clock(pieces: Sequence[Piece]) -> ClockRate | None:
    """Fit reference time over device time, pairs of (n,) [s] for each record.

    None where too few rows have both, or the reference stands or runs back. It is nan where it is not known.
    Where a clock was set, or restarted, between two records, a line begins there of its own, with the same slope.
    """
    points = _Points.of(pieces)
    if points is None:
        return None
    tried = [line for pick in (np.min, np.mean) if (line := _line(points, pick)) is not None]
    if not tried:
        return None
    best = min(tried, key=lambda line: line.std)
    line = tried[0] if tried[0].std * MAX_SIGMA_RATIO <= best.std else best
    std = float(np.hypot(line.std, points.grain / np.sqrt(6) / np.ptp(points.t)))  # both ends uniform within it
    late = points.behind - line.slope * points.t
    delay = max(float(np.quantile(late[b], 0.9) - late[b].min()) for b in points.blocks)
    # x ppm fast: the reference moves by 1 / (1 + 1e-6 x) of what device time does
    rate = 1 + line.slope
    if not rate > 0:  # it stands, or runs back: no time
        return None
    return ClockRate(PPM_PER_ONE * (1 / rate - 1), PPM_PER_ONE * std / rate**2, line.dof, delay)


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """Device time and by how much the reference has moved more (n,) [s]; blocks of rows, their records, sessions.

    ``least`` [s] is what a float, or stamps with few decimals, leave open of each point, ``grain`` what coarse
    stamps leave open of all.
    """

    t: FloatArray
    behind: FloatArray
    blocks: list[IntArray]
    record: IntArray
    session: IntArray
    least: float
    grain: float

    @classmethod
    def of(cls, pieces: Sequence[Piece]) -> "_Points | None":
        known = [(t[keep], u[keep]) for t, u in pieces if (keep := np.isfinite(u) & np.isfinite(t)).any()]
        known.sort(key=lambda piece: float(np.median(piece[1])))
        known, grain = _ticks(known) if known else (known, 0.0)
        if sum(len(t) for t, _ in known) < 2 * MIN_LINE_BLOCKS:
            return None
        t0, u0 = known[0][0][0], known[0][1][0]  # a float holds a quarter microsecond of seconds since 1970
        known = [(t - t0, (u - u0) - (t - t0)) for t, u in known]
        t, behind = (np.concatenate(each) for each in zip(*known, strict=True))
        blocks, record = _blocks([piece[0] for piece in known])
        if len(blocks) < MIN_LINE_BLOCKS:
            return None
        session = np.array(_sessions(known))[record]
        rounding = 4 * float(np.spacing(max(np.abs(t).max(), abs(u0))))
        scatter = _scatter_in(t, behind, blocks)
        decimals = _resolution(known, u0, rounding)
        # pulses of a good clock come at whole milliseconds as well, and do not scatter
        least = max(rounding, decimals / np.sqrt(12) if scatter > LEAST_SCATTER * decimals else 0.0)
        return cls(t, behind, blocks, record, session, least, grain)


def _resolution(known: Sequence[Piece], u0: float, rounding: float) -> float:
    """Return the coarsest of `DECIMALS_S` [s] of which all stamps are multiples, 0 where they are of none.

    ``known`` hold device time and what the reference since ``u0`` [s] moved more.
    """
    stamps = np.concatenate([behind + t for t, behind in known]) + u0
    for step in DECIMALS_S:
        if np.all(np.abs(stamps - np.round(stamps / step) * step) <= rounding):
            return step
    return 0.0


def _scatter_in(t: FloatArray, behind: FloatArray, blocks: Sequence[IntArray]) -> float:
    """Return by how much rows scatter about a line through each block [s], rms, in the median of blocks."""
    about = []
    for each in blocks:
        x, y = t[each] - t[each].mean(), behind[each] - behind[each].mean()
        about.append(float(np.std(y - x * (x @ y) / max(x @ x, np.finfo(float).tiny))))
    return float(np.median(about))


def _ticks(known: list[Piece]) -> tuple[list[Piece], float]:
    """Return the rows at which a coarse reference goes on, and how far [s] the row before is; else all rows."""
    is_tick = [np.diff(u, prepend=u[0]) != 0 for _, u in known]
    steps = np.concatenate([np.diff(t) for t, _ in known])
    if not len(steps) or sum(map(np.count_nonzero, is_tick)) >= COARSE_TICK_SHARE * len(steps):
        return known, 0.0
    grain = float(np.median(steps))
    near = [np.diff(t, prepend=-np.inf) < 1.5 * grain for t, _ in known]
    ticks = [(t[a & b], u[a & b]) for (t, u), a, b in zip(known, is_tick, near, strict=True) if (a & b).any()]
    return ticks, grain


def _sessions(known: Sequence[Piece]) -> list[int]:
    """Return a number for each record, another from where a clock was set or restarted."""
    found = [0]
    for (t, behind), (later, after) in pairwise(known):
        leap = abs(float(np.median(after) - np.median(behind)))
        is_restarted = later[0] <= t[-1] or leap > MAX_CLOCK_LEAP_S + MAX_CLOCK_DRIFT * (later[-1] - t[0])
        found.append(found[-1] + is_restarted)
    return found


def _blocks(times: Sequence[FloatArray]) -> tuple[list[IntArray], IntArray]:
    """Cut the records to about `LINE_BLOCKS` blocks of equal length, and say of which record each is."""
    rows = np.split(np.arange(sum(map(len, times))), np.cumsum([len(t) for t in times])[:-1])
    spans = np.array([t[-1] - t[0] for t in times])
    blocks, record = list[IntArray](), list[int]()
    least = MIN_RECORD_BLOCKS if len(rows) <= MAX_RECORDS_APART else 1
    for i, one in enumerate(rows):
        share = LINE_BLOCKS * spans[i] / spans.sum() if spans.sum() > 0 else 1.0
        parts = np.array_split(one, max(1, min(max(round(share), least), len(one) // MIN_BLOCK_ROWS)))
        blocks += parts
        record += [i] * len(parts)
    return blocks, np.array(record)


def _line(points: _Points, pick: Callable[[FloatArray], float]) -> CorrelatedLine | None:
    """Fit a line through what is picked of each block; where its offset surely steps, a session begins again."""
    session, line = points.session, None
    for _ in range(MAX_DELAY_STEPS + 1):
        found, index = _line_in(points, session, pick)
        if found is None:
            return line
        line = found
        if line.step is None:
            break
        at = index[line.step]
        later = (session == session[at]) & (np.arange(len(session)) >= at)
        session = np.where(later, session.max() + 1, session)
    return line


def _line_in(
    points: _Points, session: IntArray, pick: Callable[[FloatArray], float]
) -> tuple[CorrelatedLine | None, IntArray]:
    """Fit a line through what is picked of each block about the line before; return the blocks it goes through.

    Between records delays may change, which bends the usual slope: what is picked by the line is fitted again.
    """
    slope = 0.0
    middle = np.array([points.t[b].mean() for b in points.blocks])
    for _ in range(ENVELOPE_PASSES):
        slope += median_slope(middle, _picked(points, slope, pick), session) or 0.0
    line: CorrelatedLine | None = None
    for _ in range(LINE_PASSES):
        picked = _picked(points, slope, pick)
        keep = np.flatnonzero(_inliers(picked, session))
        if len(keep) < MIN_LINE_BLOCKS:
            return None, keep
        line = fit_correlated_line(middle[keep], picked[keep], session[keep], points.least, points.record[keep])
        if line is None:
            return None, keep
        slope += line.slope
        line = replace(line, slope=slope)
    return line, keep


def _picked(points: _Points, slope: float, pick: Callable[[FloatArray], float]) -> FloatArray:
    """Return what is picked of each block's delays about a slope."""
    off = points.behind - slope * points.t
    return np.array([pick(off[b]) for b in points.blocks])


def _inliers(off: FloatArray, session: IntArray) -> BoolArray:
    """Mark the points near the line of their session."""
    off = off.copy()
    for each in np.unique(session):
        off[session == each] -= np.median(off[session == each])
    far = np.abs(off)
    return np.asarray(far <= OUTLIER_SIGMAS * max(STD_PER_MAD * float(np.median(far)), np.finfo(float).tiny))

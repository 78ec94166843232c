"""Time stamps of a log from elsewhere, made to rise from row to row: wraps, rows of one read, stamps out of order.

What is left uneven (bursts, late and rounded stamps, gaps) `procedures.counts.sample_times` models.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray

WRAP_WORDS = tuple(2.0**bits for bits in (8, 16, 24, 32, 48))
WRAP_DECIMALS = (1e3, 6e4, 1e6, 3.6e6, 6e7, 1e9, 8.64e7, 6.048e8, 3.6e9, 8.64e10, 6.048e11)  # ticks
WRAP_SECONDS = (1.0, 60.0, 3600.0, 43200.0, 86400.0, 604800.0)  # of the minute, hour, day, week
SAME_WRAP_STEPS = 3.0  # usual steps, within which wraps are of one modulus
MAX_SHARE_OUT_OF_ORDER = 0.05  # of the rows: more are no late ones
MIN_WRAP_STEPS = 8.0  # usual steps that a stamp must fall back for a wrap


class StampsGoBack(ValueError):
    """Stamps fall back at ``row`` from ``before`` to ``after``, and not by a modulus that they wrap at."""

    def __init__(self, row: int, before: float, after: float) -> None:
        self.row, self.before, self.after = row, before, after
        super().__init__(f"time stamps fall back from {before:.12g} to {after:.12g} in row {row}")


@dataclass(frozen=True, slots=True, eq=False)
class LogTimes:
    """Times (n,) [s] that rise from row to row, the first at 0, and what had to be done to the stamps.

    ``origin`` [s] is the first stamp's own time.
    """

    t: FloatArray
    origin: float = 0.0
    wraps: int = 0
    modulus: float = 0.0
    shared: int = 0
    out_of_order: int = 0

    def notes(self) -> list[str]:
        """Return what was done, in words."""
        said = list[str]()
        if self.wraps:
            said.append(f"time stamps wrap {self.wraps} times, at {self.modulus:.12g}")
        if self.shared:
            said.append(
                f"{self.shared} rows have the time stamp of the row before: they are spaced evenly in between"
            )
        if self.out_of_order:
            said.append(f"{self.out_of_order} time stamps are earlier than the row before: rows keep their order")
        return said


def log_times(stamps: FloatArray, tick: float) -> LogTimes:
    """Return times of stamps (n,) of ``tick`` [s] each.

    Raises
    ------
    StampsGoBack
        If stamps fall back by what is neither a wrap nor a few rows out of order.
    """
    step = np.diff(stamps)
    usual = float(np.median(step[step > 0])) if np.any(step > 0) else 1.0
    wrapped = np.flatnonzero(step < -MIN_WRAP_STEPS * usual) + 1
    modulus = _modulus(stamps, step, wrapped, usual, tick) if len(wrapped) else 0.0
    turns = np.zeros(len(stamps))
    turns[wrapped] = 1.0
    t = (stamps - stamps[0] + np.cumsum(turns) * modulus) * tick
    late = np.maximum.accumulate(t)
    out_of_order = int(np.sum(t < late))
    if out_of_order > MAX_SHARE_OUT_OF_ORDER * len(t):
        row = int(np.flatnonzero(t < late)[0])
        raise StampsGoBack(row, float(stamps[row - 1]), float(stamps[row]))
    spread, shared = _spread(late, usual * tick)
    origin, shared = float(stamps[0] * tick), shared - out_of_order
    return LogTimes(spread - spread[0], origin, len(wrapped), modulus, shared, out_of_order)


def _modulus(stamps: FloatArray, step: FloatArray, wrapped: IntArray, usual: float, tick: float) -> float:
    """Return the modulus that all falls of the stamps have in common: a round one, or one that returns."""
    fall = usual - step[wrapped - 1]
    within = SAME_WRAP_STEPS * usual
    for modulus in sorted((*WRAP_WORDS, *WRAP_DECIMALS, *(second / tick for second in WRAP_SECONDS))):
        inside = max(-stamps.min(), 0) + stamps.max() < modulus
        if inside and np.all(np.abs(fall - modulus) <= within):
            return modulus
    middle = float(np.median(fall))
    if len(wrapped) > 1 and np.all(np.abs(fall - middle) <= within):
        return middle
    row = int(wrapped[0])
    raise StampsGoBack(row, float(stamps[row - 1]), float(stamps[row]))


def _spread(t: FloatArray, usual: float) -> tuple[FloatArray, int]:
    """Return times (n,) [s] whose rows of one stamp lie evenly between it and the one before, and their number.

    ``usual`` [s] is the step between stamps, for rows of the first.
    """
    begins = np.flatnonzero(np.concatenate(([True], np.diff(t) > 0)))
    if len(begins) == len(t):
        return t, 0
    size = np.diff(np.append(begins, len(t)))
    stamp = t[begins]
    before = np.concatenate(([stamp[0] - usual], stamp[:-1]))
    within = np.arange(len(t)) - np.repeat(begins, size) + 1
    share = within / np.repeat(size, size)
    spread: FloatArray = np.repeat(before, size) + share * np.repeat(stamp - before, size)
    return spread, len(t) - len(begins)

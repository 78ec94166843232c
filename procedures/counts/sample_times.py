"""When samples were taken, from the time stamps of their rows; stamps of any log made to increase.

A stamp may be that of a read that brought many rows at once, late, shaken or rounded. So a long step between two
stamps is a gap only where the lateness that it brings *lasts*: rows that are missing make all that follow late,
rows that were held back are followed by others that come the sooner.

`log_times` makes the stamps of a log from elsewhere rise: wraps, rows of one read, stamps out of order.
"""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.statistics.significance import STD_PER_MAD

GAP_PERIODS = 1.5  # a step longer than so many sample periods is a gap
# Relative: of a stated period that is right, and of one that is not wrong
RIGHT_PERIOD_TOLERANCE, NEAR_PERIOD_TOLERANCE = 1e-3, 1e-2
LASTING_DELAY_PERIODS = 0.6  # sample periods
# Looked at before and after a long step: so many runs, of no more rows together
MAX_COMPARED_RUNS, MAX_COMPARED_ROWS = 8, 200
# Relative, of steps that are alike; and the part of them that are
USUAL_STEP_TOLERANCE, MIN_USUAL_SHARE = 0.1, 0.95
OUTLIER_SIGMAS = 4.0  # robust sigmas
MAX_LATE_SHARE = 0.1  # of the recording, that a stamp is late at the most
MIN_STEP_RATIO = 1.25  # times the largest other step between runs
RANK_EXCESS_OF_NEARLY_ALL = 0.45  # above one half: of the pairs of runs that rank alike where all but a few do
MAX_PERIOD_ITERATIONS = 4
MIN_ROWS_OF_A_RATE = 100  # that show another rate than the stated one: of a few each may stand behind a gap


@dataclass(frozen=True, slots=True, eq=False)
class SampleTimes:
    """When rows were taken: ``t`` (n,) [s], and the first row of each gap-free segment, (s,).

    ``period`` [s] is the mean one within segments. With ``is_uneven`` the stamps are no times of samples: ``t`` is
    then a regular grid in each segment, as late as no stamp contradicts, and ``period_std`` [s] is 1 sigma of the
    period.
    """

    t: FloatArray
    period: float
    begins: IntArray
    is_uneven: bool = False
    period_std: float = 0.0


def sample_times(stamps: FloatArray, nominal: float) -> SampleTimes:
    """Return the times of samples ``nominal`` [s] apart whose stamps (n,) [s] rise from row to row.

    Where no period within 1 % of the nominal goes with them, the nominal is wrong, and one is found without.
    """
    for bound, guesses in (
        (RIGHT_PERIOD_TOLERANCE, [nominal]),
        (NEAR_PERIOD_TOLERANCE, [*_near(stamps, nominal), nominal]),
    ):
        for guess in guesses:
            found = _in_sequence(stamps, guess)
            if abs(found.period / nominal - 1) <= bound:
                return _unless_the_rate_changes(stamps, found)
    found, right = _in_sequence(stamps, nominal), _unless_the_rate_changes(stamps, _by_themselves(stamps))
    # a gap at every row, and none where the stamps are taken by themselves: the rate is half as high, or less
    is_lower = 2 * len(found.begins) > len(stamps) >= MIN_ROWS_OF_A_RATE and 4 * len(right.begins) < len(stamps)
    if found.is_uneven or is_lower:
        return right
    return replace(found, period=right.period)


def own_period(stamps: FloatArray) -> float:
    """Return the mean sample period [s] that stamps (n,) [s], rising from row to row, show by themselves."""
    return _by_themselves(stamps).period


def _unless_the_rate_changes(t: FloatArray, found: SampleTimes) -> SampleTimes:
    """Return the stamps as they are where the grid is so far off them that no read is so late."""
    if not found.is_uneven or float(np.max(t - found.t)) <= MAX_LATE_SHARE * float(t[-1] - t[0]):
        return found
    return SampleTimes(t, float((t[-1] - t[0]) / (len(t) - 1)), np.zeros(1, dtype=np.int64))


def _by_themselves(stamps: FloatArray) -> SampleTimes:
    """Return the times with a period that comes out again where it is taken for the nominal."""
    found = _in_sequence(stamps, _pace(stamps))
    for _ in range(MAX_PERIOD_ITERATIONS):
        before, found = found, _in_sequence(stamps, found.period)
        if abs(found.period / before.period - 1) <= RIGHT_PERIOD_TOLERANCE:
            break
    return found


def _near(t: FloatArray, nominal: float) -> list[float]:
    """Return what the period may be: the mean of steps that are not long, or of rows between long ones."""
    step = np.diff(t)
    is_long = step > GAP_PERIODS * nominal
    found = [float(step[~is_long].mean())] if not is_long.all() else []
    ends = np.flatnonzero(is_long)
    if len(ends) > 2:
        apart = max(1, min(len(ends) - 2, round(MAX_COMPARED_ROWS / float(np.diff(ends).mean()))))
        found.append(float(np.median((t[ends[apart:]] - t[ends[:-apart]]) / (ends[apart:] - ends[:-apart]))))
    return sorted(found, key=lambda each: abs(each - nominal))


def _pace(t: FloatArray) -> float:
    """Return about the period [s] that stamps show by themselves: of stretches, or of steps nearly all alike."""
    step = np.diff(t)
    rows = max(min(MAX_COMPARED_ROWS, len(step) // 2), 1)
    far = float(np.median(t[rows:] - t[:-rows])) / rows
    usual = step[np.abs(step - np.median(step)) <= USUAL_STEP_TOLERANCE * np.median(step)]
    if len(usual) > MIN_USUAL_SHARE * len(step) and far < GAP_PERIODS * usual.mean():
        return float(usual.mean())
    return far


def _in_sequence(t: FloatArray, period: float) -> SampleTimes:
    """Return the times, the period being about ``period`` [s]."""
    step = np.diff(t)
    long = np.flatnonzero(step > GAP_PERIODS * period) + 1
    if not len(long):
        return SampleTimes(t, float(step.mean()) if len(step) else period, np.zeros(1, dtype=np.int64))
    gaps = _lasting(t - period * np.arange(len(t)), long, LASTING_DELAY_PERIODS * period)
    begins = np.concatenate(([0], gaps)).astype(np.int64)
    inside = np.delete(step, gaps - 1)
    if len(inside) < len(step) / 2:  # these are no gaps: the period is wrong
        return SampleTimes(t, _pace(t), begins)
    if len(gaps) == len(long):
        return SampleTimes(t, float(inside.mean()), begins)
    return _on_a_grid(t, begins, long, float(inside.mean()))


def _lasting(late: FloatArray, long: IntArray, least: float) -> IntArray:
    """Return those rows of ``long`` from which on all are later than before, by more than ``least`` [s].

    The least late rows of some runs before and after decide; of stamps that are uneven a few rows do not.
    """
    begin, end = np.concatenate(([0], long)), np.append(long, len(late))
    head, tail = (np.array([late[i].min() for i in _slices(begin, end, side)]) for side in (1, -1))
    after, before = head[1:].copy(), tail[:-1].copy()
    for k in range(1, MAX_COMPARED_RUNS):
        later, sooner = slice(None, -k), slice(k, None)
        reach = begin[1:][sooner] - begin[1:][later] < MAX_COMPARED_ROWS
        after[later] = np.where(reach, np.minimum(after[later], head[1:][sooner]), after[later])
        before[sooner] = np.where(reach, np.minimum(before[sooner], tail[:-1][later]), before[sooner])
    gaps, first = list[int](), 0
    for j in (np.flatnonzero(after - before > least) + 1).tolist():
        since = range(max(j - MAX_COMPARED_RUNS, first), j)  # not before the last gap
        if after[j - 1] - min(tail[k] for k in since if begin[j] - end[k] < MAX_COMPARED_ROWS) > least:
            gaps.append(int(begin[j]))
            first = j
    if len(gaps) == len(long):
        return np.array(gaps, dtype=np.int64)
    gaps = _beyond_chance(late, begin, end, gaps)
    some = min(float(MAX_COMPARED_ROWS), 3 * float(np.median(end - begin)))  # rows that decide
    following = np.append(gaps[1:], len(late)) if gaps else np.zeros(0)
    return np.array([gap for gap, then in zip(gaps, following, strict=True) if then - gap >= some], dtype=np.int64)


def _beyond_chance(late: FloatArray, begin: IntArray, end: IntArray, gaps: list[int]) -> list[int]:
    """Return those gaps that stamps without a loss would not show by chance.

    A step up is a loss where it exceeds all steps between neighbouring runs, or where the runs after it rank above
    those before (Mann and Whitney, Annals of Mathematical Statistics 18, 1947).
    """
    least = np.minimum.reduceat(late, begin)
    at = np.searchsorted(begin, gaps)
    usual = MIN_STEP_RATIO * float(np.abs(np.delete(np.diff(least), at - 1)).max(initial=0.0))
    runs = [(least[max(j - MAX_COMPARED_RUNS, 0) : j], least[j : j + MAX_COMPARED_RUNS]) for j in at.tolist()]
    step = [after.min() - before.min() for before, after in runs]
    found = np.array([0, len(least)])
    for i in np.argsort(step)[::-1]:  # the others are then looked at between those found
        j = int(at[i])
        next_one = int(np.searchsorted(found, j))
        since = max(found[next_one - 1], np.searchsorted(end, begin[j] - MAX_COMPARED_ROWS, side="right"))
        until = min(found[next_one], np.searchsorted(begin, begin[j] + MAX_COMPARED_ROWS))
        before, after = least[since:j], least[j:until]
        rise = after[:MAX_COMPARED_RUNS].min() - before[-MAX_COMPARED_RUNS:].min()
        if rise > usual or _ranks_above(after, before):
            found = np.insert(found, next_one, j)
    return [int(begin[j]) for j in found[1:-1]]


def _ranks_above(after: FloatArray, before: FloatArray) -> bool:
    """Say whether values after are larger than before by more than chance, of two samples of one distribution."""
    n, m = len(before), len(after)
    share = float(np.mean(after[:, None] > before))
    std = np.sqrt((n + m + 1) / (12 * n * m))
    return min(n, m) > 1 and share - 0.5 > min(OUTLIER_SIGMAS * float(std), RANK_EXCESS_OF_NEARLY_ALL)


def _slices(begin: IntArray, end: IntArray, side: int) -> list[slice]:
    """Return the first or the last rows of each run."""
    if side > 0:
        end = np.minimum(end, begin + MAX_COMPARED_ROWS)
    else:
        begin = np.maximum(begin, end - MAX_COMPARED_ROWS)
    return [slice(b, e) for b, e in zip(begin.tolist(), end.tolist(), strict=True)]


def _on_a_grid(t: FloatArray, begins: IntArray, long: IntArray, period: float) -> SampleTimes:
    """Return a regular grid for each segment, its pace that of the rows before long steps: the least late ones."""
    ends, rows = np.setdiff1d(long - 1, begins - 1), np.arange(len(t))
    std = GAP_PERIODS * period / len(t)  # of the mean from end to end
    for _ in range(2 if np.ptp(ends) > len(t) / 2 else 0):
        x, y = (_about_mean(each[ends], np.searchsorted(begins, ends, side="right")) for each in (rows, t))
        if x @ x == 0:
            break
        period = float(x @ y / (x @ x))
        off = np.abs(y - period * x)
        scatter = max(float(off @ off) / max(len(off) - 2, 1), (1e-3 * period) ** 2)
        std = float(np.sqrt(scatter / (x @ x)))
        ends = ends[off <= OUTLIER_SIGMAS * STD_PER_MAD * max(float(np.median(off)), 1e-3 * period)]
    least = np.minimum.reduceat(t - period * rows, begins)
    grid = period * rows + np.repeat(least, np.diff(np.append(begins, len(t))))
    return SampleTimes(grid, period, begins, is_uneven=True, period_std=std)


def _about_mean(values: FloatArray | IntArray, segment: IntArray) -> FloatArray:
    total, count = np.bincount(segment, values), np.maximum(np.bincount(segment), 1)
    return np.asarray(values - (total / count)[segment])


WRAP_WORDS = tuple(2.0**bits for bits in (8, 16, 24, 32, 48))
WRAP_DECIMALS = (1e3, 6e4, 1e6, 3.6e6, 6e7, 1e9, 8.64e7, 6.048e8, 3.6e9, 8.64e10, 6.048e11)  # ticks
WRAP_SECONDS = (1.0, 60.0, 3600.0, 43200.0, 86400.0, 604800.0)  # of the minute, hour, day, week
SAME_WRAP_STEPS = 3.0  # usual steps, within which wraps are of one modulus
MAX_SHARE_OUT_OF_ORDER = 0.05  # of the rows: more are no late ones
MIN_ROOM = 0.75  # of a sample period, that a row of a shared stamp has: half of it is too little
MIN_WRAP_STEPS = 8.0  # usual steps that a stamp must fall back for a wrap


class StampsGoBack(ValueError):
    """Stamps fall back at ``row`` from ``before`` to ``after``, and not by a modulus that they wrap at.

    ``usual`` is the step between other rows, in the stamps' own unit.
    """

    def __init__(self, row: int, before: float, after: float, usual: float) -> None:
        self.row, self.before, self.after, self.usual = row, before, after, usual
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
        text = list[str]()
        if self.wraps:
            text.append(f"time stamps wrap {self.wraps} times, at {self.modulus:.12g}")
        if self.shared:
            text.append(
                f"{self.shared} rows have the time stamp of the row before: they are spaced evenly in between"
            )
        if self.out_of_order:
            text.append(f"{self.out_of_order} time stamps are earlier than the row before: rows keep their order")
        return text


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
        raise StampsGoBack(row, float(stamps[row - 1]), float(stamps[row]), usual)
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
    raise StampsGoBack(row, float(stamps[row - 1]), float(stamps[row]), usual)


def _spread(t: FloatArray, usual: float) -> tuple[FloatArray, int]:
    """Return times (n,) [s] whose rows of one stamp lie evenly between it and the one before, and their number.

    A stamp that stood still lies in a step that is too short for its rows, and the step after it is long enough
    for them: its first row keeps it, and the others go into that step. ``usual`` [s] is the step between stamps,
    for rows of the first.
    """
    begins = np.flatnonzero(np.concatenate(([True], np.diff(t) > 0)))
    if len(begins) == len(t):
        return t, 0
    size = np.diff(np.append(begins, len(t)))
    step = np.diff(t[begins], prepend=t[0] - usual)
    period = float(np.median(step / size))
    room = np.append(step[1:] / (size[:-1] + size[1:] - 1), 0.0)  # of each row, with those of the stamp
    stood_still = (size > np.median(size)) & (step / size < MIN_ROOM * period) & (room > MIN_ROOM * period)
    stamped = begins + np.where(stood_still, 0, size - 1)  # the row of each stamp that has its time
    rows = np.arange(len(t))
    times: FloatArray = np.interp(rows, stamped, t[begins])
    first = rows[: stamped[0]]
    times[first] = t[0] - usual * (stamped[0] - first) / size[0]
    return times, len(t) - len(begins)

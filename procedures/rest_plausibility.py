"""Whether specific force and rate at rest are physically possible, and integers printed without their sign.

At rest the specific force is gravity's reaction, 9.76 to 9.84 m/s2 on Earth, and the direction of gravity in the
sensor's axes stands still, so that a rate across it is the gyroscope's own error (Titterton & Weston, 11.3); one
along it may be a turntable's. A wrong unit scales all of a recording: one rest which agrees is enough.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from procedures.arrays import BoolArray, FloatArray, true_runs
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY

MIN_REST_S = 1.0
CELL_S = 0.2  # means over it; vibration of machines is faster, motion by hand and of vehicles is slower
MIN_SAMPLES = 8  # in a rest: fewer are alike by chance
STEADY = 0.02  # relative, of gravity or of the specific force if that is larger: how far cells of a rest differ
GRAVITY_TOLERANCE = 0.2  # relative: gravity varies by 0.4 %, the bias of a cheap accelerometer is below 0.1 g
MATCH_TOLERANCE = 0.1  # relative: how near an explanation must come; ranges differ by factors of two
MAX_CENTRE_M = 1.0  # distance from the axis of a turntable: its centripetal acceleration adds to gravity
MAX_CALIBRATED_RATE = 0.1 * RAD_PER_DEG  # at rest, of a calibrated gyroscope: its bias and the Earth's rate
MAX_RAW_RATE = 20.0 * RAD_PER_DEG  # at rest, of an uncalibrated one: zero-rate output in data sheets of MEMS
SIGMAS = 3.0
MAX_ACROSS = 0.174  # sine of 10 deg: a turn's axis this near to gravity is taken for along it
RANGES = (0.0625, 0.125, 0.25, 0.5, 2.0, 4.0, 8.0, 16.0)  # full-scale ranges of one sensor, over another
MOST_NAMED = 4  # explanations in a message
USUAL_G = (0.2, 5.0)  # of the middle specific force of a recording that never rests: vehicle, hand, aircraft
_CHUNK = 256  # cells that are looked at together
_DECADES, _PER_DECADE = 12, 50  # of the histogram from which the middle specific force is read

Quantity = Literal["specific force", "angular rate"]
ALL_AXES: BoolArray = np.ones(3, dtype=np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """A stretch in which the specific force stands still.

    Attributes
    ----------
    first, samples : index of its first sample in the recording, and how many there are
    seconds : duration
    force : (3,) mean specific force [m/s2]
    rate : (3,) mean angular rate [rad/s]; nan without gyroscopes
    rate_noise : standard error of ``rate``'s length [rad/s], and of what the specific force shows of a turn
    across : rate across gravity that the specific force does not follow [rad/s]; nan where it is unknown
    """

    first: int
    samples: int
    seconds: float
    force: FloatArray
    rate: FloatArray
    rate_noise: float
    across: float

    @property
    def length(self) -> float:
        """Length of the mean specific force [m/s2]."""
        return float(np.linalg.norm(self.force))

    def allowed_rate(self, bias: float) -> float:
        """Return the largest rate across gravity [rad/s] that a ``bias`` [rad/s], noise and alignment explain."""
        turned = float(np.linalg.norm(self.rate))
        below = min(STANDARD_GRAVITY / max(self.length, STANDARD_GRAVITY), 1.0)  # on a turntable, off its centre
        return bias + SIGMAS * self.rate_noise + turned * (MAX_ACROSS + float(np.sqrt(1 - below**2)))


@dataclass(frozen=True, slots=True, eq=False)
class Contradiction:
    """A quantity that is physically impossible at ``rest``, or in the middle of a recording without one (None).

    ``found`` is in m/s2 or rad/s; ``allowed`` is the largest rate that is possible.
    """

    quantity: Quantity
    found: float
    rest: Rest | None
    allowed: float = float("nan")


@dataclass(slots=True, eq=False)
class RestSurvey:
    """Finds rests in samples that come block by block, in memory that does not grow.

    ``period`` [s] is that of a sample. ``axes`` (3,) says which accelerometers there are. ``max_rate`` [rad/s] is
    the bias that the gyroscopes may have. `verdict` is of all samples so far.
    """

    period: float
    axes: BoolArray = field(default_factory=lambda: ALL_AXES)
    max_rate: float = MAX_CALIBRATED_RATE
    _impossible: dict[Quantity, Rest] = field(default_factory=dict)  # the longest rest of each
    _agrees: bool = False  # whether the specific force of any rest is possible
    _agreeing_rate: float = np.inf  # the smallest `allowed_rate` of rests whose rate is possible
    _sum: FloatArray = field(default_factory=lambda: np.zeros(6))  # of the samples of the cell that is not full
    _summed: int = 0
    _cells: list[FloatArray] = field(default_factory=list)  # that were not looked at
    _held: int = 0
    _before: int = 0  # cells that were looked at
    _lengths: FloatArray = field(default_factory=lambda: np.zeros(2 * _DECADES * _PER_DECADE + 1))

    @property
    def cell(self) -> int:
        """Samples in a cell."""
        return max(round(CELL_S / self.period), 1)

    @property
    def width(self) -> int:
        """Cells in the shortest rest."""
        seconds = int(np.ceil(MIN_REST_S / (self.cell * self.period) - 1e-6))
        return max(seconds, -(-MIN_SAMPLES // self.cell), 2)

    @np.errstate(all="ignore")  # what overflows is no rest
    def take(self, force: FloatArray, rate: FloatArray) -> list[Rest]:
        """Take specific force [m/s2] and rate [rad/s], each (n, 3), nan where there is none; return rests."""
        begin, n = 0, self.cell
        self._note_lengths(force[:: max(n // 4, 1)])
        if self._summed:
            begin = min(n - self._summed, len(force))
            self._add_up(force[:begin], rate[:begin])
        whole = (len(force) - begin) // n
        if whole:
            inside = slice(begin, begin + whole * n)
            self._note(np.hstack([part[inside].reshape(whole, n, 3).mean(axis=1) for part in (force, rate)]))
        self._add_up(force[begin + whole * n :], rate[begin + whole * n :])
        return self._look(self.width - 1) if self._held >= _CHUNK + self.width else []

    @np.errstate(all="ignore")
    def finish(self) -> list[Rest]:
        """Return the rests that the last samples make."""
        return self._look(0) if self._held else []

    def verdict(self) -> Contradiction | None:
        """Return what is impossible, first of the specific force; None where nothing is."""
        if not self._agrees and self._lengths.any():
            if (rest := self._impossible.get("specific force")) is not None:
                return Contradiction("specific force", rest.length, rest)
            usual = self._middle_length()
            low, high = (STANDARD_GRAVITY * g for g in USUAL_G)
            if usual > high or (usual < low and self.axes.all()):
                return Contradiction("specific force", usual, None)
        rest = self._impossible.get("angular rate")
        if rest is not None and rest.across < self._agreeing_rate:
            return Contradiction("angular rate", rest.across, rest, rest.allowed_rate(self.max_rate))
        return None

    def _add_up(self, force: FloatArray, rate: FloatArray) -> None:
        self._sum += np.concatenate((force.sum(axis=0), rate.sum(axis=0)))
        self._summed += len(force)
        if self._summed == self.cell:
            self._note((self._sum / self._summed)[None])
            self._sum, self._summed = np.zeros(6), 0

    def _note(self, cells: FloatArray) -> None:
        self._cells.append(cells)
        self._held += len(cells)

    def _note_lengths(self, force: FloatArray) -> None:
        length = np.linalg.norm(force, axis=1)
        length = np.maximum(length[np.isfinite(length)], 10.0**-_DECADES)
        at = np.rint(np.log10(np.minimum(length, 10.0**_DECADES)) * _PER_DECADE).astype(np.int64)
        self._lengths += np.bincount(at + _DECADES * _PER_DECADE, minlength=len(self._lengths))

    def _middle_length(self) -> float:
        total = np.cumsum(self._lengths)
        middle = int(np.searchsorted(total, total[-1] / 2))
        return float(10.0 ** (middle / _PER_DECADE - _DECADES))

    def _look(self, keep: int) -> list[Rest]:
        """Find and judge the rests in the cells that are held, of which ``keep`` are looked at again."""
        cells = np.vstack(self._cells)
        found = list(_rests(cells, self.width, self._before, self.cell, self.period))
        self._before += len(cells) - keep
        self._cells, self._held = [cells[len(cells) - keep :]], keep
        for rest in found:
            self._judge(rest)
        return found

    def _judge(self, rest: Rest) -> None:
        spin = float(np.nan_to_num(np.linalg.norm(rest.rate)))
        low, high = (STANDARD_GRAVITY * (1 + sign * GRAVITY_TOLERANCE) for sign in (-1, 1))
        if rest.length > high + spin**2 * MAX_CENTRE_M or (rest.length < low and self.axes.all()):
            self._keep("specific force", rest)
            return
        self._agrees = True
        if self.axes.all() and np.isfinite(rest.across):
            if rest.across > (allowed := rest.allowed_rate(self.max_rate)):
                self._keep("angular rate", rest)
            else:
                self._agreeing_rate = min(self._agreeing_rate, allowed)

    def _keep(self, quantity: Quantity, rest: Rest) -> None:
        if quantity not in self._impossible or rest.seconds > self._impossible[quantity].seconds:
            self._impossible[quantity] = rest


def contradiction(
    force: FloatArray, rate: FloatArray | None, sample_rate: float, *,
    axes: BoolArray = ALL_AXES, max_rate: float = MAX_CALIBRATED_RATE,
) -> Contradiction | None:  # fmt: skip
    """Return what is physically impossible in a recording that is in memory.

    Parameters
    ----------
    force : (n, 3) float64, m/s2
        Specific force.
    rate : (n, 3) float64, rad/s, optional
        Angular rate.
    sample_rate : Hz
        Of both.
    axes : (3,) boolean
        Which accelerometers there are.
    max_rate : rad/s
        As of `RestSurvey`.
    """
    survey = RestSurvey(1 / sample_rate, axes, max_rate)
    survey.take(force, np.full_like(force, np.nan) if rate is None else rate)
    survey.finish()
    return survey.verdict()


def _rests(cells: FloatArray, width: int, before: int, cell: int, period: float) -> Iterable[Rest]:
    if len(cells) < width:
        return
    windows = np.lib.stride_tricks.sliding_window_view(cells[:, :3], width, axis=0)  # (m, 3, width)
    mean = windows.mean(axis=2)
    with np.errstate(invalid="ignore"):
        apart = np.sqrt(((windows - mean[:, :, None]) ** 2).sum(axis=1).max(axis=1))
        is_steady = apart <= STEADY * np.maximum(np.linalg.norm(mean, axis=1), STANDARD_GRAVITY)
    for begin, end in true_runs(is_steady).tolist():
        part = cells[begin : end + width - 1]
        yield _rest(part, (before + begin) * cell, cell, period)


def _rest(cells: FloatArray, first: int, cell: int, period: float) -> Rest:
    n, seconds = len(cells), len(cells) * cell * period
    force, rate = cells[:, :3], cells[:, 3:]
    mean_force, mean_rate = force.mean(axis=0), rate.mean(axis=0)
    length = np.linalg.norm(force, axis=1)
    if not np.isfinite(mean_rate).all() or not (length > 0).all():
        return Rest(first, n * cell, seconds, mean_force, mean_rate, float("nan"), float("nan"))
    up = force / length[:, None]
    turned = np.cross(rate, up)  # -d(up)/dt where gravity alone acts
    between, span = cell * period, (n - 1) * cell * period
    claimed = (turned[1:] + turned[:-1]).sum(axis=0) * between / 2
    missed = claimed + up[-1] - up[0]
    across = min(float(np.linalg.norm(missed)), float(np.linalg.norm(claimed))) / span
    of_rate = float(np.sqrt(rate.var(axis=0, ddof=1).sum() / n))
    of_up = float(np.sqrt(2 * up.var(axis=0, ddof=1).sum())) / span
    return Rest(first, n * cell, seconds, mean_force, mean_rate, float(np.hypot(of_rate, of_up)), across)


@dataclass(frozen=True, slots=True)
class Assumption:
    """A single thing that may have been assumed wrongly: true outputs are ``factor`` times those taken."""

    name: str
    factor: float


def explanations(
    found: Contradiction, assumptions: Sequence[Assumption], offset: FloatArray | None = None,
    max_rate: float = MAX_CALIBRATED_RATE,
) -> list[Assumption]:  # fmt: skip
    """Return which single assumptions would make it right, the best first.

    ``offset`` (3,) is what a calibration takes off, in the unit of ``found``'s quantity: it does not scale.
    """
    rest, off = found.rest, np.zeros(3) if offset is None else offset
    if found.quantity == "angular rate":  # noise goes with the factor, a bias need not
        of_noise = found.allowed - max_rate
        return [each for each in assumptions if found.found * each.factor < max_rate + of_noise * each.factor]
    if rest is None:
        low, high = (STANDARD_GRAVITY * g for g in USUAL_G)
        return [each for each in assumptions if low <= found.found * each.factor <= high]
    lengths = {each: np.linalg.norm(each.factor * (rest.force + off) - off) for each in assumptions}
    misses: Mapping[Assumption, float] = {
        each: abs(float(np.log(length / STANDARD_GRAVITY))) if length > 0 else np.inf
        for each, length in lengths.items()
    }
    near = [each for each in assumptions if misses[each] < np.log1p(MATCH_TOLERANCE)]
    return sorted(near, key=misses.__getitem__)


MIN_BITS, MAX_BITS = 8, 32  # of converters and registers
MIN_JUMPS = 2  # in each direction: fewer may be damaged rows
MAX_BETWEEN = 0.01  # share of samples in the middle half of the range
# Of the range, about zero, where no value lies: a speed that steps from 0 to 250, 500, ... deg/s leaves 0.02 free
MAX_SEAM = 0.01


def width(largest: float) -> int | None:
    """Return how many bits an unsigned integer needs; None of fewer or more than a register has."""
    bits = int(largest).bit_length() if 0 <= largest < 2.0**MAX_BITS else 0
    return bits if bits >= MIN_BITS else None


def unsigned_bits(values: FloatArray) -> int | None:
    """Return the bits of the signed integers that ``values`` (n,) [counts] shows as unsigned; None of others.

    Near zero they jump between the ends of the range; a counter that wraps jumps in one direction only.
    """
    known = values[np.isfinite(values)]
    if len(known) < 2 or known.min() < 0 or not (known == np.rint(known)).all():
        return None
    largest = float(known.max())
    bits = width(largest)
    if bits is None or largest < 0.75 * 2.0**bits:
        return None
    is_negative = known >= 2.0 ** (bits - 1)
    seam = float(known.min()) + 2.0**bits - largest
    if seam > max(
        MAX_SEAM * 2.0**bits, *(np.ptp(known[side]) for side in (is_negative, ~is_negative) if side.any())
    ):
        return None
    jumps = np.diff(known) / 2.0**bits
    if min(int((jumps > 0.5).sum()), int((jumps < -0.5).sum())) < MIN_JUMPS:
        return None
    between = np.mean((known > 0.25 * 2.0**bits) & (known < 0.75 * 2.0**bits))
    return bits if between < MAX_BETWEEN else None


def signed(values: FloatArray, bits: int) -> FloatArray:
    """Return ``values`` (n, ...) [counts] with two's complement of ``bits`` applied."""
    return np.where(values >= 2.0 ** (bits - 1), values - 2.0**bits, values)

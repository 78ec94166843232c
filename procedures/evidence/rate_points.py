"""The points of turntables: what was turned, what each sensor put out, in blocks, and the noise of a point.

A sensor is taken in where a table turns about its own axis, at more than one rate: elsewhere its scale factor is
unknown. Noise is judged by second differences of points of equal rate in three neighbouring sweeps, in which what
goes evenly with time cancels, and by their median, which a few jumps do not move; of a table that has each rate
twice by the difference of the two, of one that repeats none by three neighbours' residual. Of a point that is a
mean of rows (`averaged_points`) it is the smaller.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.campaign.campaign import Campaign, RateTable
from procedures.frames import AXES
from procedures.statistics.significance import STD_PER_MAD
from procedures.units import S_PER_MIN

FEW_ROWS = 2000  # a table of no more stays as it is: each row a point
MEANT_POINTS = 1000
JUMP_SHARE = 1e-3  # of the range of rates: a step between two rows that is no noise of the reference
SPREAD_SHARE = 1e-2  # of the range, within a point: a cubic in it is off by 1e-4 of itself


def averaged(table: RateTable) -> tuple[RateTable, FloatArray]:
    """Return a table of at most some three thousand points, and of how many rows (n,) [1] each is the mean.

    A table of few rows is returned as it is. Time is the mean of a point's rows, so that it rises.
    """
    rows = len(table.reference)
    if rows <= FEW_ROWS:
        return table, np.ones(rows)
    begin = _cut(table, -(-rows // MEANT_POINTS))
    count = np.diff(np.append(begin, rows)).astype(np.float64)
    kept = _kept(count, rows / MEANT_POINTS)

    def mean(values: FloatArray) -> FloatArray:
        found: FloatArray = (np.add.reduceat(values, begin, axis=0).T / count).T
        return found[kept]

    T, t = _mean_of_known(table.temperature, begin)[kept], None if table.t is None else mean(table.t)
    return RateTable(table.name, table.axis, mean(table.reference), mean(table.output), T, t), count[kept]


def _cut(table: RateTable, size: int) -> IntArray:
    """Return the first rows of parts of at most ``size`` rows in which the rate hardly moves."""
    reference, rows = table.reference, len(table.reference)
    span = float(np.ptp(reference))
    absent = np.isnan(table.output)
    is_break = np.any(absent[1:] != absent[:-1], axis=1)
    jumps = np.abs(np.diff(reference)) > JUMP_SHARE * span
    if jumps.sum() <= MEANT_POINTS:  # else it sweeps: every row is a step
        is_break |= jumps
    first = np.concatenate(([0], np.flatnonzero(is_break) + 1))
    length = np.diff(np.append(first, rows))
    at = np.arange(rows) - np.repeat(first, length)
    part = at * np.repeat(-(-length // size), length) // np.repeat(length, length)
    begin = np.flatnonzero(np.concatenate(([True], is_break | (np.diff(part) != 0))))
    while (moves := _moves(reference, begin, SPREAD_SHARE * span)).any():
        middle = begin + np.diff(np.append(begin, rows)) // 2
        begin = np.sort(np.concatenate((begin, middle[moves])))
    return begin.astype(np.int64)


def _moves(reference: FloatArray, begin: IntArray, most: float) -> BoolArray:
    """Say of each part of several rows whether the rate moves in it by more than ``most``."""
    moved: BoolArray = np.maximum.reduceat(reference, begin) - np.minimum.reduceat(reference, begin) > most
    return moved


def _kept(count: FloatArray, size: float) -> IntArray:
    """Return which parts are taken: of those below half the usual ``size``, evenly, no more than are meant."""
    short = np.flatnonzero(count < size / 2)
    every = -(-len(short) // MEANT_POINTS) or 1
    return np.sort(np.concatenate((np.flatnonzero(count >= size / 2), short[::every])))


def _mean_of_known(values: FloatArray, begin: IntArray) -> FloatArray:
    """Return the mean of each part's numbers; nan of a part without any."""
    known = np.isfinite(values)
    total = np.add.reduceat(np.where(known, values, 0.0), begin)
    number = np.add.reduceat(known.astype(np.float64), begin)
    return np.where(number > 0, total / np.maximum(number, 1.0), np.nan)


BLOCKS_PER_TABLE = 9
MAX_BLOCKS = 4 * BLOCKS_PER_TABLE
ROWS_BY_HAND = 200  # rows of a table that is written row by row: more are samples of a sweep, and drift together
LEAST_STAYS = 3
LEAST_OF_A_STAY = 4  # points at one rate one after the other, that can be halved
ONE_STAY = 1e-3  # of the range of rates, within which two neighbours are at one
LEAST_SPAN = 0.01  # of the fastest rate: rates that differ less do not separate a scale factor from a bias
MIN_TRIPLES = 8  # second differences that a median is taken of
LEAST_POINTS = MIN_TRIPLES + 2  # of a table: as many second differences follow from them
SAME_RATE_SHARE = 1e-4  # of the largest, within which two points have the same
# A difference: the efficiency of that median over what neighbours have in common (2/3, 1/6)
DOF_PER_DIFFERENCE = 0.37 / 1.94
DOF_PER_PAIR = 0.37  # pairs have nothing in common
EXACT = 1e-9  # of the largest output: noise that no table is below


@dataclass(frozen=True, slots=True, eq=False)
class RatePoints:
    """All tables' n points, and the r outputs read there.

    ``omega`` (n, 3) [deg/s] in IMU axes, ``temperature`` (n,) [degC], ``t`` (n,) [s], ``warming`` (n,) [K/min],
    ``block`` (n,); ``blocks`` holds of each its table's name, number in the table and campaign,
    ``clocks`` the clock that its time is of. ``at`` (r,) is an
    output's point, ``sensor`` (r,) its sensor, ``output`` (r,) what was read. ``parameters`` (p, 2): sensor, and
    the axis turned about or -1 for the bias. ``count`` (r,) is of how many rows an output is the mean.
    """

    omega: FloatArray
    temperature: FloatArray
    t: FloatArray
    warming: FloatArray
    block: IntArray
    blocks: tuple[tuple[str, int, int], ...]
    at: IntArray
    sensor: IntArray
    output: FloatArray
    parameters: IntArray
    clocks: tuple[int, ...]
    count: FloatArray

    def design(self) -> FloatArray:
        """Return (r, p): what a unit of each parameter adds to each output."""
        found = np.zeros((len(self.output), len(self.parameters)))
        for i, (sensor, axis) in enumerate(self.parameters):
            rows = self.sensor == sensor
            found[rows, i] = 1.0 if axis < 0 else self.omega[self.at[rows], axis]
        return found

    def scale(self, x: FloatArray) -> FloatArray:
        """Return the scale factor (3,) [output/(deg/s)] for parameters x; nan of a sensor not taken in."""
        k = np.full(3, np.nan)
        for sensor in np.unique(self.sensor):
            rates = (self.parameters[:, 0] == sensor) & (self.parameters[:, 1] >= 0)
            own = rates & (self.parameters[:, 1] == sensor)
            k[sensor] = np.sign(x[own][0]) * np.linalg.norm(x[rates])
        return k


def read_points(campaigns: Sequence[Campaign]) -> RatePoints | None:
    """Return the points of one unit's tables; None if no sensor's own axis was turned about."""
    tables = [(n, table) for n, each in enumerate(campaigns) for table in each.rate_tables]
    tables = [(n, table) for n, table in tables if len(table.reference) >= LEAST_POINTS]
    if not tables:
        return None
    means = [averaged(table) for _, table in tables]
    tables = [(n, mean) for (n, _), (mean, _) in zip(tables, means, strict=True)]
    axes = [campaigns[n].fixture.C_sb[:, AXES.index(table.axis)] for n, table in tables]
    output = np.concatenate([table.output for _, table in tables])
    omega = np.concatenate(
        [table.reference[:, None] * axis for (_, table), axis in zip(tables, axes, strict=True)]
    )
    read = np.isfinite(output)
    turned = np.abs(omega) > 0
    span = np.stack([np.ptp(omega[known, i]) if known.any() else 0.0 for i, known in enumerate(read.T)])
    own = (np.sum(read & turned, axis=0) >= LEAST_POINTS // 2) & (span > LEAST_SPAN * np.abs(omega).max(axis=0))
    at, sensor = np.nonzero(read & own)
    if not len(at):
        return None
    named = [(q, p) for q in np.flatnonzero(own) for p in range(3) if (read[:, q] & turned[:, p]).any()]
    named += [(q, -1) for q in np.flatnonzero(own)]
    cut = [blocks_of(table.reference) for _, table in tables]
    sizes = [int(part.max()) + 1 for part in cut]
    block = np.concatenate([sum(sizes[:i]) + part for i, part in enumerate(cut)])
    blocks = tuple(
        (table.name, i + 1, n) for (n, table), size in zip(tables, sizes, strict=True) for i in range(size)
    )
    temperature = np.concatenate([table.temperature for _, table in tables])
    t = np.concatenate([_time(table) for _, table in tables])
    warming = np.concatenate([_warming(table) for _, table in tables])
    clocks = np.repeat(_clocks(tables), sizes)
    return RatePoints(
        omega, temperature, t, warming, block, blocks, at, sensor, output[at, sensor], np.array(named),
        tuple(clocks.tolist()), np.concatenate([count for _, count in means])[at],
    )  # fmt: skip


def blocks_of(reference: FloatArray) -> IntArray:
    """Return the index (n,) of the block of each point of a table at the rates ``reference`` (n,), in its order.

    Blocks are held out in turn, and the rest must still hold about every rate: else the fastest, at which a
    nonlinearity shows, would be predicted from slower ones. So blocks end in the middles of stays at one rate; of
    a table written row by row every so many-th point is a block.
    """
    parts = min(BLOCKS_PER_TABLE, len(reference) // 2)
    even = np.repeat(np.arange(parts), [len(b) for b in np.array_split(reference, parts)])
    span = float(np.ptp(reference))
    rate = np.round(reference / (ONE_STAY * span or 1.0)).astype(np.int64)
    blocks_of_rate = {each: len(np.unique(even[rate == each])) for each in np.unique(rate).tolist()}
    if min(blocks_of_rate[int(each)] for each in (rate.min(), rate.max())) > 1:
        return even
    first = np.flatnonzero(np.abs(np.diff(reference, prepend=np.inf)) > ONE_STAY * span)
    length = np.diff(np.append(first, len(reference)))
    is_long = length >= LEAST_OF_A_STAY
    if length[is_long].sum() >= len(reference) / 2 and is_long.sum() >= LEAST_STAYS:
        middles = (first + length // 2)[is_long]
        chosen = middles[:: -(-len(middles) // MAX_BLOCKS)]
        found: IntArray = np.searchsorted(chosen, np.arange(len(reference)), side="right")
        return found
    return np.arange(len(reference)) % parts if len(reference) <= ROWS_BY_HAND else even


def _clocks(tables: Sequence[tuple[int, RateTable]]) -> list[int]:
    """Return each table's clock: its own where tables of its campaign were at one time, else the campaign's."""
    known = [(n, t[np.isfinite(t)]) for n, t in ((n, _time(table)) for n, table in tables)]
    spans = [(n, float(t.min()), float(t.max())) for n, t in known if len(t)]
    apart = itertools.pairwise(sorted(spans))
    overlapping = {n for (n, _, end), (other, begin, _) in apart if n == other and begin < end}
    return [1 + i if n in overlapping else 0 for i, (n, _) in enumerate(tables)]


def _time(table: RateTable) -> FloatArray:
    return np.full(len(table.reference), np.nan) if table.t is None else table.t


def _warming(table: RateTable) -> FloatArray:
    """Return the rate of temperature (n,) [K/min] at a table's points; nan where one is unknown."""
    t, T = _time(table), table.temperature
    known = np.isfinite(t) & np.isfinite(T)
    found = np.full(len(t), np.nan)
    if known.sum() > 1:
        found[known] = np.gradient(T[known], t[known] / S_PER_MIN)
    return found


def noise_of(points: RatePoints, residual: FloatArray) -> tuple[FloatArray, float]:
    """Return the noise (r,) [output] of an output, one a sensor, and its degrees of freedom.

    ``residual`` (r,) is what a line leaves.
    """
    found, dof = np.empty(len(residual)), np.inf
    for sensor in np.unique(points.sensor):
        rows = np.flatnonzero(points.sensor == sensor)
        differences = _of_equal_rates(points, rows)
        per = DOF_PER_DIFFERENCE
        if len(differences) < MIN_TRIPLES:
            differences, per = _pairs_of_equal_rates(points, rows), DOF_PER_PAIR
        if len(differences) < MIN_TRIPLES:
            smooth = _less_smooth(points, rows, residual[rows])
            differences, per = _second(smooth, points.count[rows]), DOF_PER_DIFFERENCE
        sigma = STD_PER_MAD * float(np.median(np.abs(differences))) or float(np.std(differences))
        least = EXACT * float(np.max(np.abs(points.output[rows])))
        found[rows] = np.maximum(sigma / np.sqrt(points.count[rows]), least)
        dof = min(dof, per * len(differences))
    return found, dof


def same_rates(omega: FloatArray) -> IntArray:
    """Return numbers (n, ...) [1] that are equal where rates ``omega`` (n, ...) [deg/s] were set the same."""
    found: IntArray = np.round(omega / (SAME_RATE_SHARE * np.max(np.abs(omega)))).astype(np.int64)
    return found


def _equal_rates(points: RatePoints, rows: IntArray) -> list[IntArray]:
    """Return one sensor's ``rows`` (r,) in groups of equal rates, each in the order of the file."""
    _, group = np.unique(same_rates(points.omega[points.at[rows]]), axis=0, return_inverse=True)
    return [rows[group == number] for number in range(group.max() + 1)]


def _of_equal_rates(points: RatePoints, rows: IntArray) -> FloatArray:
    """Return second differences of one sensor's outputs (r,) at equal rates."""
    groups = _equal_rates(points, rows)
    return np.concatenate([_second(points.output[each], points.count[each]) for each in groups])


def _pairs_of_equal_rates(points: RatePoints, rows: IntArray) -> FloatArray:
    """Return by how much two outputs at one rate differ beyond the usual, each as large as a row's noise."""
    pairs = np.array([each[:2] for each in _equal_rates(points, rows) if len(each) > 1]).reshape(-1, 2)
    if not len(pairs):
        return np.zeros(0)
    apart = points.output[pairs[:, 1]] - points.output[pairs[:, 0]]
    found: FloatArray = (apart - np.median(apart)) / np.sqrt(np.sum(1 / points.count[pairs], axis=1))
    return found


def _less_smooth(points: RatePoints, rows: IntArray, residual: FloatArray) -> FloatArray:
    """Return a line's residual (r,) without what usual nonlinearities explain, as wide as the noise was."""
    u = points.omega[points.at[rows]]
    u = u[:, int(np.argmax(np.ptp(u, axis=0)))] / np.max(np.abs(u))
    shapes = np.column_stack((np.ones(len(u)), u, np.abs(u), u * np.abs(u), u**3))
    free = len(u) - shapes.shape[1]
    if free < MIN_TRIPLES:
        return residual
    left = residual - shapes @ np.linalg.lstsq(shapes, residual, rcond=None)[0]
    found: FloatArray = left * np.sqrt(len(u) / free)
    return found


def _second(values: FloatArray, count: FloatArray) -> FloatArray:
    """Return second differences (n - 2,) of means of ``count`` (n,) rows, each as large as a row's noise."""
    variance = 1 / count[:-2] + 4 / count[1:-1] + 1 / count[2:]
    found: FloatArray = (values[:-2] - 2 * values[1:-1] + values[2:]) / np.sqrt(variance)
    return found

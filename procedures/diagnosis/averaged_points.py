"""A long table's rows as points: those that lie side by side at nearly one rate are averaged.

A logger that runs while a table turns writes a row a sample, a thousand for each rate: as many unknown noises, of
which a mean holds all there is to know. Rows are cut where the rate jumps, where an output is absent, and into
parts of about as many rows each; a part in which the rate still moves is halved until it hardly does. Where a
sweep leaves more than a fit can hold, these short parts are taken evenly from the whole: sigma grows, and
stays honest.
"""

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.campaign.campaign import RateTable

FEW_ROWS = 2000  # a table of no more stays as it is: each row a point
MEANT_POINTS = 1000
JUMP_SHARE = 1e-3  # of the range of rates: a step between two rows that is no noise of the reference
SPREAD_SHARE = 1e-2  # of the range, within a point: a cubic in it is off by 1e-4 of itself


def averaged(table: RateTable) -> tuple[RateTable, FloatArray]:
    """Return a table of at most some three thousand points, and of how many rows (n,) each is the mean.

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

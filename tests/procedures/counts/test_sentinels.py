"""Sentinels of a log do not depend on the blocks in which it comes."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.sentinels import Sentinels

N = 3000
DRAW = np.random.default_rng(8)
NOISE = np.rint(DRAW.normal(0, 9000, (N, 6)))


def spoiled(rows: FloatArray | list[int], columns: slice, number: float) -> FloatArray:
    values = NOISE.copy()
    values[np.asarray(rows, dtype=int), columns] = number
    return values


def late(values: FloatArray, constants: tuple[float, ...]) -> FloatArray:
    values = values.copy()
    for i, constant in enumerate(constants):
        values[: 200 * (i + 1), i] = constant
    return values


CASES = {
    "far apart": (spoiled([10, 1500, 2990], slice(1), 1e7), 3),
    "two are few": (spoiled([10, 2990], slice(1), 1e7), 0),
    "in sequence": (spoiled([998, 999, 1000, 1001, 2000, 2001, 2500], slice(1), -1e7), 7),
    "stays": (spoiled(list(range(995, 1300)), slice(1), 1e7), 0),
    "all zero at first": (spoiled(list(range(1200)), slice(6), 0.0), 7200),
    "zero for most of the time": (spoiled(list(range(1600)), slice(6), 0.0), 0),
    "zero, ending one after the other": (late(NOISE, (0.0,) * 6), 1200),
    "other constants at first": (late(NOISE, (0.0, 1.0, 0.0, 1.0, 0.0, 1.0)), 0),
    "an absent channel": (np.column_stack((spoiled([7, 2000], slice(5), 5.0)[:, :5], np.zeros(N))), 10),
    "empty at first": (late(spoiled([700, 2000], slice(6), 5.0), (np.nan,) * 3), 12),
}


@pytest.mark.parametrize("size", [N, 1000, 7, 1])
@pytest.mark.parametrize("name", CASES)
def test_sentinels_do_not_depend_on_blocks(name: str, size: int) -> None:
    values, cells = CASES[name]
    found = Sentinels(6)
    for begin in range(0, N, size):
        found.add(values[begin : begin + size])
    marked = found.cells(values)
    assert marked.sum() == cells
    assert np.array_equal(found.cells(values[7:8]), marked[7:8])

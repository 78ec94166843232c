"""Names for the array types that cross a public boundary; interpolation of vectors over time; runs of rows."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def interpolated(t: FloatArray, times: FloatArray, values: FloatArray) -> FloatArray:
    """Return values (n, 3) at other times, by straight lines.

    Parameters
    ----------
    t : (n,) [s], where values are wanted
    times : (m,) [s], rising
    values : (m, 3), of any unit and frame
    """
    return np.stack([np.interp(t, times, values[:, i]) for i in range(3)], axis=1)


def finite_rows(values: FloatArray) -> BoolArray:
    """Return the rows (n,) of ``values`` (n, k), any unit, in which all are finite."""
    finite: BoolArray = np.logical_and.reduce(np.isfinite(values), axis=1)
    return finite


def true_runs(mask: BoolArray) -> IntArray:
    """Return begin and end (m, 2) [rows] of each run that ``mask`` (n,) marks, in order; the end is not of it."""
    return np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])))).reshape(-1, 2)

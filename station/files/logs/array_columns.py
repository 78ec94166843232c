"""Named arrays as the columns of a table: a vector is one, a matrix ``acc`` becomes ``acc:1``, ``acc:2``, ..."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from station.errors import DataRefused

MAX_COLUMNS = 1000  # of one matrix


def array_columns(arrays: Mapping[str, Any], file: Path) -> dict[str, FloatArray]:
    """Return the columns (n,) of all arrays that have as many rows as the longest; text and others are left out.

    Raises
    ------
    DataRefused
        If no array of numbers with two rows or more is among them.
    """
    numbers = {name: found for name, value in _fields(arrays) if (found := _matrix(value)) is not None}
    rows = max((len(matrix) for matrix in numbers.values()), default=0)
    if rows < 2:
        held = ", ".join(arrays) or "nothing"
        raise DataRefused(
            file, None, f"{held}", "arrays of numbers with a row a sample", "save them so", code=ErrorCode.TABLE
        )
    columns = dict[str, FloatArray]()
    for name, matrix in numbers.items():
        if len(matrix) != rows:
            continue
        for j in range(matrix.shape[1]):
            columns[name if matrix.shape[1] == 1 else f"{name}:{j + 1}"] = np.ascontiguousarray(matrix[:, j])
    return columns


def _fields(arrays: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield all arrays, the fields of structured ones each by its own name."""
    for name, value in arrays.items():
        if names := np.asarray(value).dtype.names:
            yield from ((f"{name}.{field}", np.asarray(value)[field]) for field in names)
        else:
            yield name, value


def seconds_of(values: Any) -> Any:
    """Return moments or spans of time (numpy's) in seconds, of moments since 1970, nan where empty; else as is."""
    if values.dtype.kind not in "mM":
        return values
    whole = values.astype(f"{values.dtype.kind}8[ns]")
    return np.where(np.isnat(whole), np.nan, whole.astype(np.int64) / 1e9)


def _matrix(value: Any) -> FloatArray | None:
    """Return an array of numbers as a matrix with a row a sample, None if it is none."""
    array = seconds_of(np.asarray(value))
    if array.dtype.kind not in "buif" or array.ndim not in {1, 2} or not array.size:
        return None
    matrix = array.astype(np.float64).reshape(len(array), -1)
    if matrix.shape[1] > len(matrix):  # a row a channel, as many tools write
        matrix = matrix.T
    return matrix if matrix.shape[1] <= MAX_COLUMNS else None

"""Arrays that a program gives: numbers, or refused in one line."""

from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused

LARGEST = 1e30  # of an output a second: beyond it no device counts, and squares of it are no numbers


def numbers(values: Any, name: str) -> FloatArray:
    """Return (n,) or (n, k) numbers in their own unit; raise `DataRefused` for all else, named ``name``."""
    try:
        found = np.asarray(values)
    except (ValueError, TypeError):  # rows of different lengths
        raise DataRefused(name, None, "rows of different lengths", "an array of numbers", "correct it") from None
    if found.size and found.dtype.kind not in "buif":
        expected = "numbers of a kind such as float64"
        raise DataRefused(name, None, f"an array of {found.dtype}", expected, "convert it")
    return found.astype(np.float64, copy=False)

"""``.npz``: arrays saved by numpy, each with a row a sample."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.logs.array_columns import array_columns
from station.files.logs.damage import DAMAGE, in_a_line
from station.files.logs.log_table import LogTable


def read_npz_log(file: Path) -> LogTable:
    """Read a ``.npz``; raise `DataRefused` where it is none or holds no numbers. No pickled object is opened."""
    try:
        found = np.load(file, allow_pickle=False)
        if isinstance(found, np.ndarray):  # a .npy by another name
            arrays, objects = {"data": found}, list[str]()
        else:
            with found:
                arrays, objects = _arrays(found)
    except DAMAGE as error:
        raise DataRefused(
            file, None, f"no readable arrays ({in_a_line(error)})", "a .npz of numbers", code=ErrorCode.TABLE
        ) from None
    columns = array_columns(arrays, file)
    notes = (f"{', '.join(objects)} of Python objects: not used",) if objects else ()
    moments = frozenset(name for name, values in arrays.items() if values.dtype.kind in "mM")
    return LogTable(file, columns, hashlib.sha256(file.read_bytes()).hexdigest(), notes=notes, moments=moments)


def _arrays(found: Any) -> tuple[dict[str, Any], list[str]]:
    """Return the arrays of an archive, and the names of those that hold objects: to open one runs its code."""
    arrays, objects = dict[str, Any](), list[str]()
    for name in found.files:
        try:
            arrays[name] = found[name]
        except ValueError as error:
            if "allow_pickle" not in str(error):
                raise
            objects.append(name)
    return {name: value for name, value in arrays.items() if isinstance(value, np.ndarray)}, objects

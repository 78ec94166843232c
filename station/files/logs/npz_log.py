"""``.npz``: arrays saved by numpy, each with a row a sample."""

import hashlib
import zipfile
from pathlib import Path

import numpy as np

from station.errors import DataRefused
from station.files.logs.array_columns import array_columns
from station.files.logs.log_table import LogTable


def read_npz_log(file: Path) -> LogTable:
    """Read a ``.npz``; raise `DataRefused` where it is none or holds no numbers. No pickled object is opened."""
    try:
        with np.load(file, allow_pickle=False) as found:
            arrays = {name: found[name] for name in found.files}
    except (ValueError, zipfile.BadZipFile, EOFError, AttributeError) as error:
        raise DataRefused(file, None, f"no readable arrays ({error})", "a .npz of numbers") from None
    columns = array_columns(arrays, file)
    return LogTable(file, columns, hashlib.sha256(file.read_bytes()).hexdigest())

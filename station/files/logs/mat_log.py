"""``.mat`` of MATLAB up to version 7: variables, and fields of structures as ``imu.acc``; text of that name."""

import hashlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.logs.array_columns import array_columns
from station.files.logs.log_table import LogTable
from station.files.logs.text_log import read_text_log

HEAD_BYTES = 512
_TEXT = re.compile(rb"[\t\r\n -~]+")
MAX_DEPTH = 4  # of structures in structures


def read_mat_log(file: Path) -> LogTable:
    """Read a ``.mat``, or a table of text that is called so, as imu_tk's are.

    Raises
    ------
    DataRefused
        If it is neither, is of version 7.3 or holds no numbers.
    """
    with file.open("rb") as stream:
        head = stream.read(HEAD_BYTES)
    if _TEXT.fullmatch(head) and re.search(rb"[0-9]", head) and not head.startswith(b"MATLAB"):
        return read_text_log(file)
    from scipy.io import loadmat  # heavy: only where a log is a .mat

    try:
        found = loadmat(file, simplify_cells=True)
    except NotImplementedError:
        remedy = "save it again with save(..., '-v7')"
        raise DataRefused(file, None, "version 7.3 (HDF5)", "a .mat of version 7 or older", remedy) from None
    except OSError:
        raise
    except Exception as error:  # scipy raises of many kinds on damaged files
        raise DataRefused(
            file, None, f"no readable variables ({error})", "a .mat of MATLAB", code=ErrorCode.TABLE
        ) from None
    named = {name: value for name, value in found.items() if not name.startswith("__")}
    columns = array_columns(dict(_flat("", named, MAX_DEPTH)), file)
    return LogTable(file, columns, hashlib.sha256(file.read_bytes()).hexdigest())


def _flat(path: str, values: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping) and depth:
            yield from _flat(f"{path}{name}.", value, depth - 1)
        elif isinstance(value, np.ndarray):
            yield f"{path}{name}", value

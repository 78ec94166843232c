"""What reads a table from elsewhere, by the suffix of its file."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from procedures.error_codes import ErrorCode
from station.errors import DataRefused

T = TypeVar("T")


def read_by_suffix(file: Path, formats: Mapping[str, Callable[[Path], T]], other: Callable[[Path], T]) -> T:
    """Return what the format of a file's suffix makes of it, ``other`` of one that has none.

    Raises
    ------
    DataRefused
        If the file cannot be read or holds no table: with file, place, found, expected and what to do.
    """
    try:
        return formats.get(file.suffix.lower(), other)(file)
    except OSError as error:
        found = error.strerror or str(error)
        raise DataRefused(
            file, None, found.lower(), "a readable file", "name another", code=ErrorCode.FILE_MISSING
        ) from None

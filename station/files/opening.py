"""Opening a file that a campaign names: inside its folder, regular, of a bearable size."""

import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from procedures.errors import ErrorCode
from station.errors import DataRefused

MAX_FILE = 4 * 2**30  # bytes
MAX_LINE = 2**20  # bytes


def open_inside(folder: Path, name: str, named_in: str | Path, line: int | None) -> BufferedReader:
    """Open the regular file ``name`` of ``folder`` for reading bytes.

    Parameters
    ----------
    named_in, line
        Where the name stands; a name that cannot be accepted is blamed on it.

    Raises
    ------
    DataRefused
        If the name leads outside the folder, or there is no regular file of at most 4 GiB.
    """
    expected = f"the name of a file inside {folder}"
    if not name or "\0" in name or os.path.isabs(name):
        raise DataRefused(named_in, line, repr(name), expected)
    root, target = os.path.realpath(folder), os.path.realpath(folder / name)
    if os.path.commonpath((root, target)) != root:
        raise DataRefused(named_in, line, f"{name!r}, which leads to {target}", expected)
    try:
        _check(os.stat(target), folder / name)
        descriptor = os.open(target, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        if line is None:  # no file names it: every such folder has one
            raise DataRefused(named_in, None, f"no {name}", "one", "check the name") from None
        raise DataRefused(named_in, line, f"{name!r}, which does not exist", expected) from None
    except OSError as error:
        raise DataRefused(named_in, line, f"{name!r} ({error.strerror})", expected) from error
    stream = os.fdopen(descriptor, "rb")
    try:
        _check(os.fstat(descriptor), folder / name)
    except DataRefused:
        stream.close()
        raise
    return stream


def unreadable(file: Path, error: OSError) -> DataRefused:
    """Return the refusal of a file that cannot be read."""
    found = (error.strerror or str(error)).lower()
    return DataRefused(file, None, found, "a readable file", "name another", ErrorCode.FILE_MISSING)


def sha256_inside(folder: Path, name: str, named_in: str | Path, line: int | None) -> str:
    """Return the hash of the bytes of such a file."""
    with open_inside(folder, name, named_in, line) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _check(status: os.stat_result, path: Path) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a device, pipe or socket"
        raise DataRefused(path, None, kind, "a regular file")
    if status.st_size > MAX_FILE:
        raise DataRefused(path, None, f"{status.st_size} bytes", f"at most {MAX_FILE} bytes (4 GiB)")

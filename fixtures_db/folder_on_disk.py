"""Files and folders that survive a power cut: a file's own fsync keeps its bytes, its folder's keeps its name."""

import os
from pathlib import Path
from typing import IO, Any


def make_folder(folder: Path) -> None:
    """Make a folder and those above it that are missing, each on the disk with its name when this returns.

    Raise `OSError` if one of them cannot be made; one that is there is left as it is.
    """
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for each in missing:
        sync_folder(each.parent)


def sync_folder(folder: Path) -> None:
    """Put a folder's entries on the disk."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_file(stream: IO[Any]) -> None:
    """Put what was written to an open file on the disk."""
    stream.flush()
    os.fsync(stream.fileno())

"""One station to a campaign folder: a lock that the kernel lets go of when its holder ends, however it ends."""

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from station.errors import CannotWrite, cannot_write

LOCK_FILE = ".lock"
LOCK_PATIENCE_S = 0.5  # whoever only looks holds the lock for less than this
_POLL_S = 0.01


class FolderInUse(CannotWrite):
    """Another station records into the folder."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "another station is recording into it")
        self.args = (f"{folder}: another station is recording into it, expected it free; go on there, or end it",)


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold a folder while the ``with`` lasts; raise `FolderInUse` if another process does."""
    path, deadline = folder / LOCK_FILE, time.monotonic() + LOCK_PATIENCE_S
    while (descriptor := _taken(path)) is None:
        if time.monotonic() > deadline:
            raise FolderInUse(folder)
        time.sleep(_POLL_S)
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _taken(path: Path) -> int | None:
    """Return the descriptor of the lock, None while another holds it."""
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise cannot_write(path, error) from error
    if _lock(descriptor) and _is_at(path, descriptor):
        return descriptor
    os.close(descriptor)
    return None


def is_locked(folder: Path) -> bool:
    """Say whether another process holds a folder."""
    try:
        descriptor = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        return not _lock(descriptor)
    finally:
        os.close(descriptor)


def _lock(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_at(path: Path, descriptor: int) -> bool:
    """Say whether the locked file is still the one of that name: its last holder may have removed it."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False

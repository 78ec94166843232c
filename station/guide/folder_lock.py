"""One station to a campaign folder: a lock that the kernel lets go of when its holder ends, however it ends."""

import fcntl
import os
import time
from pathlib import Path
from types import TracebackType

from station.errors import CannotWrite, cannot_write

LOCK_FILE = ".lock"
LOCK_PATIENCE_S = 0.5  # whoever only looks holds the lock for less than this
_POLL_S = 0.01


class FolderInUse(CannotWrite):
    """Another station records into the folder."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "another station is recording into it")
        self.args = (f"{folder}: another station is recording into it, expected it free; go on there, or end it",)


class FolderLock:
    """Holds a folder while the ``with`` lasts; raises `FolderInUse` if another process does."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._descriptor: int | None = None

    def __enter__(self) -> "FolderLock":
        deadline = time.monotonic() + LOCK_PATIENCE_S
        while not self._take():
            if time.monotonic() > deadline:
                raise FolderInUse(self._folder)
            time.sleep(_POLL_S)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        if self._descriptor is not None:
            (self._folder / LOCK_FILE).unlink(missing_ok=True)
            os.close(self._descriptor)
            self._descriptor = None

    def _take(self) -> bool:
        path = self._folder / LOCK_FILE
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise cannot_write(path, error) from error
        if _lock(descriptor) and _is_at(path, descriptor):
            self._descriptor = descriptor
            return True
        os.close(descriptor)
        return False


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

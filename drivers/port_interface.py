"""What every port of bytes does, whatever is behind it; the simplest is a file of recorded bytes."""

from typing import IO, Protocol

from drivers.errors import LinkLost, ReplayEnded


class Port(Protocol):
    """Bytes from and to a device; every call returns within its timeout.

    ``read`` returns what has come, at most ``max_bytes``, at once when anything has; empty when nothing
    came within the timeout. It raises `LinkLost` when the port is gone and `ReplayEnded` at the end of a
    replayed file. ``close`` may be called twice.
    """

    def read(self, max_bytes: int) -> bytes:
        """Return what has come; see the class."""
        ...

    def write(self, data: bytes) -> None:
        """Send ``data`` whole."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...


class ReplayPort:
    """An open file of bytes as a device sent them."""

    def __init__(self, file: IO[bytes], path: str) -> None:
        self.path = path
        self._file, self._size = file, 0

    def read(self, max_bytes: int) -> bytes:
        """Return the next bytes; raise `ReplayEnded` when there are none."""
        try:
            data = self._file.read(max_bytes)
        except OSError as error:
            raise LinkLost(self.path, error.strerror or str(error)) from error
        if not data:
            raise ReplayEnded(self.path, self._size)
        self._size += len(data)
        return data

    def write(self, data: bytes) -> None:
        """Take ``data`` and drop it: a recording does not listen."""

    def close(self) -> None:
        """Close the file."""
        self._file.close()

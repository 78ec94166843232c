"""A file of raw bytes, read as if it came from a device; as fast as it is asked for."""

from typing import BinaryIO

from drivers.errors import LinkLost, PortNotFound, ReplayEnded


class ReplayPort:
    """An open file of bytes as a device sent them."""

    def __init__(self, file: BinaryIO, path: str) -> None:
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


def open_replay(path: str) -> ReplayPort:
    """Open a file of raw bytes; raise `PortNotFound` where it cannot be read."""
    try:
        file = open(path, "rb")
    except OSError as error:
        reason = f"cannot be replayed ({error.strerror})"
        raise PortNotFound(path, reason, "check the file's name and permissions") from error
    return ReplayPort(file, path)

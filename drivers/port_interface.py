"""What every port of bytes does, whatever is behind it."""

from typing import Protocol


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

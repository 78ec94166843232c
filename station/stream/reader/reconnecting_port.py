"""A port that is opened again after its device was unplugged, powered off or out of reach."""

import time
from collections.abc import Callable
from threading import Event

from drivers.addresses import DeviceAddress
from drivers.errors import DriverError, LinkLost
from drivers.ports import open_port
from station.stream.reader.messages import LOST

REOPEN_S = (0.05, 0.1, 0.2, 0.4, 0.8)  # back-off; the last one again and again


class ReconnectingPort:
    """The port of an address; ``mark`` is given each loss and each return, and whether the port is open then.

    Raises `DriverError` if it cannot be opened at first. ``stop`` ends the waiting for a device that is away.
    """

    def __init__(self, address: DeviceAddress, stop: Event, mark: Callable[[str, bool], None]) -> None:
        self._address, self._stop, self._mark = address, stop, mark
        self._port = open_port(address)

    def read(self, size: int) -> bytes:
        """Return what has come, as `drivers.port_interface.Port` does; nothing if it was stopped."""
        while not self._stop.is_set():
            try:
                return self._port.read(size)
            except LinkLost as lost:
                self._reopen(lost)
        return b""

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def _reopen(self, lost: LinkLost) -> None:
        self._port.close()
        self._mark(f"{LOST}{lost.reason}", False)
        began, attempt = time.monotonic(), 0
        while not self._stop.wait(REOPEN_S[min(attempt, len(REOPEN_S) - 1)]):
            attempt += 1
            try:
                self._port = open_port(self._address)
            except DriverError:
                continue
            self._mark(f"port back after {time.monotonic() - began:.1f} s", True)
            return

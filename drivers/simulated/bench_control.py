"""Moves the cube of a simulated bench: a client of a simulated device's control port, an answer to each line.

``ok time T done D`` gives the device time now and when all queued motion will be over.
"""

import contextlib
import socket
from io import BufferedRWPair
from typing import Self

from drivers.addresses import host_and_port
from drivers.errors import BadDeviceUrl, ControlRefused, ControlUnreachable, reason_of

ANSWER_TIMEOUT_S = 5.0


def control_address(typed: str) -> tuple[str, int]:
    """Return host and port of simulated hands.

    Raises `BadDeviceUrl` if it is not HOST:PORT.
    """
    if (address := host_and_port(typed)) is None:
        found = "no HOST:PORT of simulated hands"
        raise BadDeviceUrl(typed, found, "what `station simulate` prints as control, as in 127.0.0.1:40001")
    return address


class BenchControl:
    """Moves the cube of the device whose control port is ``address``, HOST:PORT. Each move returns its end.

    Ends are device times [s]. Every command raises `ControlRefused` when the device answers ``error``, and
    `ControlUnreachable`, which is one as well, when it does not answer. An address that is none is `BadDeviceUrl`.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self._line: BufferedRWPair | None = None

    def place(self, position: int, move_s: float = 45.0) -> float:
        """Put the cube into ``position`` 1..24; return when it will have settled."""
        return self._moved(f"place {position} {move_s}")

    def carry(self, position: int, move_s: float, tremor_deg_s: float, pause_s: float = 0.0) -> float:
        """Put the cube into ``position`` 1..24 with hands that tremble and stop for ``pause_s`` in the air."""
        return self._moved(f"carry {position} {move_s} {tremor_deg_s} {pause_s}")

    def tilt(self, up: tuple[int, int, int], move_s: float = 45.0) -> float:
        """Prop the cube so that ``up``, in its own axes, about points up; return when it will have settled."""
        return self._moved(f"tilt {up[0]} {up[1]} {up[2]} {move_s}")

    def heat(self, kelvin: float, tau_s: float) -> None:
        """Warm the unit by ``kelvin`` from now on, exponentially in ``tau_s`` [s]; negative cools it."""
        self.say(f"heat {kelvin} {tau_s}")

    def turn(self, axis: str, direction: str, revolutions: int, rest_s: float = 5.0) -> float:
        """Turn the cube about its vertical ``axis``, at rest for ``rest_s`` before and after."""
        return self._moved(f"turn {axis} {direction} {revolutions} {rest_s}")

    def rest(self, seconds: float) -> float:
        """Leave the cube alone."""
        return self._moved(f"rest {seconds}")

    def time(self) -> float:
        """Return the device's time [s]."""
        return float(self.say("time")[0])

    def done(self) -> float:
        """Return the device time [s] at which all commanded motion will be over."""
        return float(self.say("status")[-1])

    def seen(self, time_s: float) -> None:
        """Say up to which device time the guide has looked; a device that is far ahead waits."""
        self.say(f"seen {max(time_s, 0.0):.3f}")

    def go(self) -> None:
        """Let a device that was started on hold begin."""
        self.say("go")

    def say(self, command: str) -> list[str]:
        """Send a line and return the words after ``ok``."""
        try:
            answer = self._ask(command)
        except OSError as error:
            self.close()
            raise ControlUnreachable(self.address, command, reason_of(error)) from error
        words = answer.split()
        if words[:1] != ["ok"]:
            raise ControlRefused(self.address, command, answer)
        return words[1:]

    def close(self) -> None:
        """Hang up; the next command calls again."""
        if self._line is not None:
            with contextlib.suppress(OSError):  # what could not be sent
                self._line.close()
        self._line = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def _moved(self, command: str) -> float:
        return float(self.say(command)[-1])

    def _ask(self, command: str) -> str:
        if self._line is None:
            with socket.create_connection(control_address(self.address), timeout=ANSWER_TIMEOUT_S) as connection:
                self._line = connection.makefile("rwb")  # keeps it open
        self._line.write(command.encode() + b"\n")
        self._line.flush()
        if not (answer := self._line.readline()).endswith(b"\n"):
            raise ConnectionResetError("closed by the device")
        return answer.decode("utf-8", "replace").strip()

"""Who moves the cube: a technician who is told in plain lines, or the hands of a simulated device."""

from collections.abc import Callable
from typing import Protocol

from drivers.errors import DriverError
from drivers.simulated.errors import SimulatorError
from drivers.simulated.hands import SimulatedHands
from procedures.frames import POSITIONS, face_of
from procedures.steps import Turn

REST_MARGIN_S = 2.0  # the bench judges rest in blocks of 1 s that begin anywhere
_WORDS = {"U": "up", "D": "down", "E": "east", "W": "west", "N": "north", "S": "south"}


class Hands(Protocol):
    """Has the cube moved. Both return the device time [s] when it will be done, None if nobody can know."""

    def place(self, position: int) -> float | None:
        """Have the cube put into ``position`` 1..12 and let go."""
        ...

    def turn(self, step: Turn) -> float | None:
        """Have the cube turned as ``step`` says, at rest before and after."""
        ...


class ConsoleHands:
    """Tells a technician; what the counts show is all the answer there is."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def place(self, position: int) -> float | None:
        """Say where each axis of the cube points in ``position``."""
        letters = POSITIONS[position - 1]
        axes = ", ".join(f"{axis} {_WORDS[letter]}" for axis, letter in zip("XYZ", letters, strict=True))
        self._say(f"Place the cube in position {position} ({letters}): {axes}. Then keep your hands off.")
        return None

    def turn(self, step: Turn) -> float | None:
        """Say which way to turn, seen from above."""
        up = face_of(step.start_position).endswith("up")
        sense = "counter-clockwise" if (step.direction == "+") == up else "clockwise"
        self._say(
            f"Turn the cube {step.revolutions} times {sense} seen from above, flat on the slab, back to exactly "
            f"where it stands; then keep your hands off for {step.rest_s:g} s."
        )
        return None


class HandsLost(DriverError):
    """The simulated hands do not answer or refuse."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


class DeviceHands:
    """The hands of a simulated device; each move takes ``move_s`` of device time."""

    def __init__(self, hands: SimulatedHands, move_s: float = 45.0) -> None:
        self._hands, self._move_s = hands, move_s

    def place(self, position: int) -> float | None:
        """Place the cube; return when it has settled."""
        return self._done(lambda: self._hands.place(position, self._move_s))

    def turn(self, step: Turn) -> float | None:
        """Turn the cube; return when its last rest is over."""
        return self._done(
            lambda: self._hands.turn(step.axis, step.direction, step.revolutions, step.rest_s + REST_MARGIN_S)
        )

    def _done(self, move: Callable[[], float]) -> float:
        try:
            return move()
        except SimulatorError as error:
            raise HandsLost(str(error)) from error

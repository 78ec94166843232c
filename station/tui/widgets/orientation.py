"""Which way the cube's faces look in each position, in letters and in words."""

from collections.abc import Sequence
from math import cos, radians

from procedures.frames import ATTITUDES, POSITIONS, TURN_START, face_of, position_name
from station.guide.view import StepView

DIRECTIONS = {"U": "up", "D": "down", "N": "north", "S": "south", "E": "east", "W": "west"}
RotationRows = Sequence[Sequence[float]]
SQUARE_DEG = 10.0  # nearer a cube is drawn square to the slab
_OPPOSITE = dict(zip("UDNSEW", "DUSNWE", strict=True))


def faces(position: int) -> dict[str, str]:
    """Return the face that looks each way in position 1..24: ``{"U": "+X", "D": "-X", "E": "+Y", ...}``."""
    looks = dict[str, str]()
    for axis, letter in enumerate(ATTITUDES[position - 1]):
        looks |= _both_ways(letter, axis, is_positive=True)
    return looks


def faces_of(C_lb: RotationRows) -> dict[str, str] | None:
    """Return the face that looks each way, from what East, North and Up are along the cube's axes.

    None where the cube stands more than `SQUARE_DEG` off any way that a position can have.
    """
    looks = dict[str, str]()
    for letter, row in zip("ENU", C_lb, strict=True):
        axis = max(range(3), key=lambda i: abs(row[i]))
        if abs(row[axis]) < cos(radians(SQUARE_DEG)):
            return None
        looks |= _both_ways(letter, axis, is_positive=row[axis] > 0)
    return looks


def nearest_face(C_lb: RotationRows) -> dict[str, str]:
    """Return the face that is up and the one that is down; which way the others look is not known."""
    up = C_lb[2]
    axis = max(range(3), key=lambda i: abs(up[i]))
    return dict.fromkeys("NSEW", "?") | _both_ways("U", axis, is_positive=up[axis] > 0)


def _both_ways(letter: str, axis: int, *, is_positive: bool) -> dict[str, str]:
    """Return the face that looks where ``letter`` says, and the one that looks away from there."""
    there, away = "+-" if is_positive else "-+"
    return {letter: f"{there}{'XYZ'[axis]}", _OPPOSITE[letter]: f"{away}{'XYZ'[axis]}"}


def start_of(step: StepView) -> int:
    """Return the position, 1..24, in which a step stands or begins."""
    with_it_up = next((p for p in range(1, len(POSITIONS) + 1) if face_of(p) == step.up), 0)
    return step.position or step.start_position or with_it_up or TURN_START[step.axis]


def is_counter_clockwise(step: StepView) -> bool:
    """Return whether a turn is counter-clockwise seen from above: right-handed about the axis that points up."""
    points_up = ATTITUDES[start_of(step) - 1]["xyz".index(step.axis)] == "U"
    return points_up == (step.direction == "+")


def short_step_title(step: StepView) -> str:
    """Return a step's short name: ``position 3``, ``turn X +``."""
    if step.is_monitor:
        return f"monitor {step.number}"
    if step.is_soak or step.is_free:
        return f"{'soak' if step.is_soak else 'free position'} {step.number}"
    again = " repeated" * bool(step.repeat) + f" ({step.repeat})" * (step.repeat > 1)
    return (
        f"position {position_name(step.position)}{again}"
        if step.position
        else f"turn {step.axis.upper()} {step.direction}"
    )

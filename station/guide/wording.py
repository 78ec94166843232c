"""Positions, faces and turns in words."""

from procedures.frames import POSITIONS, face_of
from procedures.steps import Dwell, Step, Turn

_WORDS = {"U": "up", "D": "down", "E": "east", "W": "west", "N": "north", "S": "south"}


def axes(position: int) -> str:
    """Return where each axis of the cube points in a position."""
    letters = POSITIONS[position - 1]
    return ", ".join(f"{axis} {_WORDS[letter]}" for axis, letter in zip("XYZ", letters, strict=True))


def face(name: str) -> str:
    """Return a face such as ``x_up`` in words."""
    return f"{name[0].upper()} points {name[2:]}"


def sense(turn: Turn) -> str:
    """Return which way a turn goes, seen from above."""
    up = face_of(turn.start_position).endswith("up")
    return "counter-clockwise" if (turn.direction == "+") == up else "clockwise"


def times(turn: Turn) -> str:
    """Return how often the cube is turned."""
    return "once" if turn.revolutions == 1 else f"{turn.revolutions} times"


def title(step: Step) -> str:
    """Return a step's name for people."""
    if isinstance(step, Dwell):
        return f"position {step.position}"
    return f"turn {step.axis.upper()}{step.direction}"


def task(step: Step, *, is_there: bool = False) -> str:
    """Return what is to be done; ``is_there``: the cube stands where a turn begins."""
    if isinstance(step, Dwell):
        return f"put the cube in position {step.position}: {axes(step.position)}"
    if is_there:
        speed = "" if step.speed_deg_s is None else f" at about {step.speed_deg_s:g} deg/s"
        return f"turn {times(step)} {sense(step)} from above{speed}, flat, back to where it stood"
    return f"put the cube in position {step.start_position}: {axes(step.start_position)}; then turn it"

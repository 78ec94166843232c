"""Which way the cube's faces look in each position, in letters and in words."""

from procedures.frames import POSITIONS, TURN_START, face_of
from station.guide.view import Step

DIRECTIONS = {"U": "up", "D": "down", "N": "north", "S": "south", "E": "east", "W": "west"}
_OPPOSITE = dict(zip("UDNSEW", "DUSNWE", strict=True))


def faces(position: int) -> dict[str, str]:
    """Return the face that looks each way in position 1..12: ``{"U": "+X", "D": "-X", "E": "+Y", ...}``."""
    looks = {}
    for axis, letter in zip("XYZ", POSITIONS[position - 1], strict=True):
        looks[letter], looks[_OPPOSITE[letter]] = f"+{axis}", f"-{axis}"
    return looks


def in_words(position: int) -> str:
    """Return where the axes point, the vertical one first: ``+X down, +Y north, +Z east``."""
    points = sorted(zip("XYZ", POSITIONS[position - 1], strict=True), key=lambda pair: pair[1] not in "UD")
    return ", ".join(f"+{axis} {DIRECTIONS[letter]}" for axis, letter in points)


def start_of(step: Step) -> int:
    """Return the position, 1..12, in which a step stands or begins."""
    with_it_up = next((p for p in range(1, len(POSITIONS) + 1) if face_of(p) == step.up), 0)
    return step.position or step.start_position or with_it_up or TURN_START[step.axis]


def is_counter_clockwise(step: Step) -> bool:
    """Return whether a turn is counter-clockwise seen from above: right-handed about the axis that points up."""
    points_up = POSITIONS[start_of(step) - 1]["xyz".index(step.axis)] == "U"
    return points_up == (step.direction == "+")


def sense(step: Step) -> str:
    """Return a turn in words: ``3 turns counter-clockwise seen from above``."""
    times = "1 turn" if step.revolutions == 1 else f"{step.revolutions} turns"
    return f"{times} {'counter-clockwise' if is_counter_clockwise(step) else 'clockwise'} seen from above"


def title(step: Step) -> str:
    """Return a step's short name: ``position 3``, ``turn X +``."""
    if step.is_soak or step.is_free:
        return f"{'soak' if step.is_soak else 'free position'} {step.number}"
    return f"position {step.position}" if step.position else f"turn {step.axis.upper()} {step.direction}"


def instruction(step: Step) -> str:
    """Return what is to be done with the cube, in words."""
    if step.is_free:
        return f"{title(step)}: lean it as told below, and prop it"
    if step.up:
        return f"{title(step)}: {step.up.replace('_', ' ').upper()}, any heading"
    if step.position:
        return f"{title(step)}: {in_words(step.position)}"
    return f"{title(step)}: {sense(step)}"

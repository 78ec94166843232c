"""Instructions and readings in words: positions, faces, turns, soaks, monitor steps."""

from math import floor, log10

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn
from procedures.free_positions.free_attitudes import UpDirection
from procedures.positions import ATTITUDES, face_of, position_name
from station.guide.step_names import files_as_steps
from station.guide.view import MonitoredView, SoakView, StepView

_WORDS = {"U": "up", "D": "down", "E": "east", "W": "west", "N": "north", "S": "south"}


def rounded(value: float, limit: float) -> str:
    """Return a value as finely as two digits of its limit: 0.000 for a limit of 0.029, never 4.35e-14."""
    digits = max(1 - floor(log10(abs(limit))), 0) if limit else 3
    return f"{value:.{digits}f}"


def axes_in_words(position: int) -> str:
    """Return where each axis of the cube points in a position."""
    letters = ATTITUDES[position - 1]
    return ", ".join(f"{axis} {_WORDS[letter]}" for axis, letter in zip("XYZ", letters, strict=True))


def face_in_words(name: str) -> str:
    """Return a face such as ``x_up`` in words."""
    return f"{name[0].upper()} points {name[2:]}"


def tilt_in_words(way: UpDirection) -> str:
    """Return how the cube is to be tilted: ``on an edge, X half up, Y half down``."""
    half = {sign: [axis for axis, one in zip("XYZ", way, strict=True) if one == sign] for sign in (1, -1)}
    parts = [f"{' and '.join(axes)} half {word}" for axes, word in ((half[1], "up"), (half[-1], "down")) if axes]
    return f"on {'an edge' if 0 in way else 'a corner'}, {', '.join(parts)}"


def turn_sense(turn: Turn) -> str:
    """Return which way a turn goes, seen from above."""
    up = face_of(turn.start_position).endswith("up")
    return "counter-clockwise" if (turn.direction == "+") == up else "clockwise"


def times_in_words(turn: Turn) -> str:
    """Return how often the cube is turned."""
    return "once" if turn.revolutions == 1 else f"{turn.revolutions} times"


def step_title(step: Step | StepView) -> str:
    """Return a step's name for people: ``position 3``, ``turn X+``."""
    return files_as_steps(step.name)


def rest_before(turn: Turn) -> str:
    """Return what is to be done until a turn may begin."""
    return f"wait, hands off: the cube rests before {step_title(turn)}"


def turn_instruction(turn: Turn) -> str:
    """Return how the cube is to be turned, once it may be."""
    speed = "" if turn.speed_deg_s is None else f" at about {turn.speed_deg_s:g} deg/s"
    return f"turn {times_in_words(turn)} {turn_sense(turn)} from above{speed}, flat, back to its start"


def instruction(step: Step, *, way: UpDirection = (1, 1, 0)) -> str:
    """Return where the cube is to be put; ``way``: how it is to be tilted."""
    after = f"; then leave it for {step.seconds:.0f} s" if isinstance(step, Soak | Monitor) else ""
    if isinstance(step, Dwell | Monitor) or (isinstance(step, Soak) and step.position):
        once_more = " once more" if isinstance(step, Dwell) and step.repeat else ""
        where = f"{position_name(step.position)}{once_more}"
        return f"put the cube in position {where}: {axes_in_words(step.position)}{after}"
    if isinstance(step, Soak) and step.up:
        return f"put the cube down so that {face_in_words(step.up)}{after}"
    if isinstance(step, FreePosition | Soak):
        return f"tilt the cube {tilt_in_words(way)}, near 45 deg; prop it{after}"
    where = f"{step.start_position}: {axes_in_words(step.start_position)}"
    return f"put the cube in position {where}; do not turn it before you are asked to"


def filters_in_words(seen: MonitoredView) -> str:
    """Return it for people: ``joint roll 0.003 pitch -0.001, mixer ..., 0.002 deg apart``."""
    if not seen.filters:
        return seen.text
    parts = [f"{one.name} roll {one.roll_deg:+.3f} pitch {one.pitch_deg:+.3f}" for one in seen.filters]
    apart = "" if seen.difference_deg is None else f"; {seen.difference_deg:.3f} deg apart"
    return f"{', '.join(parts)}{apart}"


def soak_in_words(soak: SoakView) -> str:
    """Return it for people: ``24.3 degC (21.0 to 24.3 so far), 8 min left``."""
    left = f"{soak.left_s / 60:.0f} min left" if soak.left_s >= 90 else f"{soak.left_s:.0f} s left"
    if soak.temperature_c is None or soak.low_c is None or soak.high_c is None:
        return f"temperature not known, {left}"
    return f"{soak.temperature_c:.1f} degC ({soak.low_c:.1f} to {soak.high_c:.1f} so far), {left}"

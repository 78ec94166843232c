"""Instructions and readings in words: positions, faces, turns, soaks, monitor steps.

Steps have names for people: ``position 3`` for the file ``dwell_03.mcap``, and back from what is typed.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from math import floor, log10

from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak, Step, Turn
from procedures.frames import ATTITUDES, face_of, position_name
from procedures.free_positions.free_attitudes import UpDirection
from station.guide.view import CalibrationView, MonitoredView, SoakView, StepView, Verdict

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
    """Return how the cube is to lean: ``on an edge, X half up, Y half down``."""
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


def step_title(step: Step) -> str:
    """Return a step's name for people."""
    if isinstance(step, Dwell):
        return f"position {step.words}"
    if isinstance(step, FreePosition):
        return f"free position {step.number}"
    if isinstance(step, Soak):
        return f"soak {step.number}"
    if isinstance(step, Monitor):
        return f"monitor {step.number}"
    return f"turn {step.axis.upper()}{step.direction}"


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
    parts = [
        f"{reading.name} roll {reading.roll_deg:+.3f} pitch {reading.pitch_deg:+.3f}" for reading in seen.filters
    ]
    apart = "" if seen.difference_deg is None else f"; {seen.difference_deg:.3f} deg apart"
    return f"{', '.join(parts)}{apart}"


def soak_in_words(soak: SoakView) -> str:
    """Return it for people: ``24.3 degC (21.0 to 24.3 so far), 8 min left``."""
    left = f"{soak.left_s / 60:.0f} min left" if soak.left_s >= 90 else f"{soak.left_s:.0f} s left"
    if soak.temperature_c is None or soak.low_c is None or soak.high_c is None:
        return f"temperature not known, {left}"
    return f"{soak.temperature_c:.1f} degC ({soak.low_c:.1f} to {soak.high_c:.1f} so far), {left}"


_FILED = re.compile(
    r"(?:[^\s:;,]*/)?\b(?:(?P<kind>dwell|move|free|soak|monitor)_(?P<number>\d\d+)(?P<again>_repeat(?P<nth>\d*))?|turn_(?P<axis>[xyz])_(?P<way>plus|minus))"
    r"(?:_\d+)?(?:\.(?:mcap|csv))?(?::\d+)?\b"
)
_KINDS = {"dwell": "position", "move": "move", "free": "free position", "soak": "soak", "monitor": "monitor"}
_WAYS = {"plus": "+", "minus": "-"}
_GAP = re.compile(r"^(?:.*/)?(?P<file>[^:/]+\.mcap)(?::\d+)?: a gap of (?P<seconds>[\d.]+) s$")
_NEAR_S = 0.5
_TYPED = (  # what people type, and what the step's words then are
    (re.compile(r"^(?:position |p)?(\d+|[udewns]{3})$"), "position {0}"),
    (re.compile(r"^(?:position |p)?(\d+|[udewns]{3}) ?r(?:epeated)?$"), "position {0} repeated"),
    (re.compile(r"^(?:turn )?([xyz]) ?([+-])$"), "turn {0}{1}"),
    (re.compile(r"^(?:turn )?([+-]) ?([xyz])$"), "turn {1}{0}"),
    (re.compile(r"^(?:free position|free|f) ?(\d+)$"), "free position {0}"),
    (re.compile(r"^(?:soak|s) ?(\d+)$"), "soak {0}"),
    (re.compile(r"^(?:monitor|m) ?(\d+)$"), "monitor {0}"),
)


def files_as_steps(text: str) -> str:
    """Return a text with positions and turns in the place of files and of steps' names."""
    return _FILED.sub(_words, text) if "_" in text else text


def step_named(text: str, steps: Iterable[StepView]) -> str:
    """Return the name of the step that ``text`` means: ``3``, ``1r``, ``+x``, ``soak 1``; empty if none."""
    typed = re.sub(r"0+(\d)", r"\1", " ".join(files_as_steps(text.lower()).lower().split()))
    wanted = next(
        (form.format(*found.groups()) for pattern, form in _TYPED if (found := pattern.match(typed))), typed
    )
    return next((step.name for step in steps if wanted == files_as_steps(step.name).lower()), "")


def without_file_names(view: CalibrationView) -> CalibrationView:
    """Return a view whose texts name no file of a step."""
    events = tuple(event.model_copy(update={"text": files_as_steps(event.text)}) for event in view.events)
    update: dict[str, object] = {name: files_as_steps(getattr(view, name)) for name in ("line", "hint", "error")}
    if view.verdict is not None:
        update["verdict"] = verdict_without_file_names(view.verdict)
    return view.model_copy(update=update | {"events": events})


def verdict_without_file_names(verdict: Verdict) -> Verdict:
    """Return a verdict whose texts name no file of a step."""
    names = ("sentence", "status_reason", "worst_residual", "change", "diagnosis", "diagnosis_text")
    update: dict[str, object] = {name: files_as_steps(getattr(verdict, name)) for name in names}
    return verdict.model_copy(update=update | {"warnings": tuple(map(files_as_steps, verdict.warnings))})


def gap_in_words(warning: str, left_out: Mapping[str, Sequence[float]]) -> str:
    """Return a warning; a gap that the guide made itself is called what it is.

    ``left_out`` holds, by file, how long the spans were that were discarded as the cube was disturbed [s].
    """
    found = _GAP.match(warning)
    if found is None:
        return warning
    file, seconds = found["file"], float(found["seconds"])
    if not any(abs(seconds - each) < _NEAR_S for each in left_out.get(file, ())):
        return f"{file}: a gap of {seconds:.3g} s: samples were lost"
    return f"{file}: {seconds:.1f} s discarded, because the cube was disturbed; the rest was accepted"


def _words(found: re.Match[str]) -> str:
    if found["kind"]:
        again = f" repeated{f' ({nth})' if (nth := found['nth']) else ''}" if found["again"] else ""
        from procedures.frames import ATTITUDES, position_name  # numerics: the form before a campaign has none

        number = int(found["number"])
        name = position_name(number) if found["kind"] == "dwell" and number <= len(ATTITUDES) else str(number)
        return f"{_KINDS[found['kind']]} {name}{again}"
    return f"turn {found['axis'].upper()}{_WAYS[found['way']]}"

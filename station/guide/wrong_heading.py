"""A position that stood turned against the marks: said as soon as the Earth rate shows it, with a redo offered.

It shows once other faces have shown the gyros' biases, so that it may be an earlier position than the last.
"""

from collections.abc import Callable
from functools import partial

from procedures.bench.heading_errors import HeadingError, stood
from procedures.campaign.plan_steps import Dwell
from station.guide.question import Asking
from station.guide.setup_view import Choice
from station.guide.stage import Stage
from station.guide.stage_context import Desk
from station.guide.view import Question

REDO, KEEP = "r", "k"


def after_dwell(desk: Desk, again: Callable[[str], Stage]) -> Stage:
    """Return what comes after an accepted dwell; ``again`` makes the usual stage, told why the cube is to move."""
    for positions, error in desk.turned_off():
        key = tuple(sorted(positions))
        if key in desk.told_off or not (dwell := _to_redo(desk, positions)):
            continue
        desk.told_off.add(key)
        told = f"position {' or '.join(map(str, key))} {stood(error)}"
        desk.story.say("rejected", told)
        if not desk.facts.asks:  # once: the second time it stands as it is, and the solution says so
            return _redo(desk, dwell, error, again) if desk.checklist.attempts[dwell.name] == 1 else again("")
        then = {REDO: partial(_redo, desk, dwell, error, again), KEEP: partial(again, "")}
        choices = (
            Choice(key=REDO, title=f"record position {dwell.position} again, set along the marks"),
            Choice(key=KEEP, title="keep it: the solution names it, the sigmas do not cover it"),
        )
        return Asking(desk, Question(text=f"{told[0].upper()}{told[1:]}.", choices=choices), then)
    return again("")


def _to_redo(desk: Desk, positions: list[int]) -> Dwell | None:
    """Return the dwell to be done again: where it may be several, the one in which the cube stands."""
    position = desk.position if desk.position in positions else positions[0]
    return desk.checklist.dwell_at(position)


def _redo(desk: Desk, dwell: Dwell, error: HeadingError, again: Callable[[str], Stage]) -> Stage:
    desk.checklist.redo(dwell.name)
    way = "counter-clockwise" if error.angle > 0 else "clockwise"
    return again(f"set position {dwell.position} along the marks: it stood too far {way}")

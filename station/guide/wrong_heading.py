"""A position that stood turned against the marks: said as soon as the Earth rate shows it, with a redo offered.

It shows once other faces have shown the gyros' biases, so that it may be an earlier position than the last.
"""

from collections.abc import Callable
from functools import partial

from procedures.bench.position_checks import HeadingError, heading_error_text
from procedures.campaign.plan_steps import Dwell
from station.guide.question_stage import QuestionStage
from station.guide.setup_view import Choice
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.guide.view import OperatorQuestion

REDO, KEEP = "r", "k"


def after_dwell(context: StageContext, again: Callable[[str], Stage]) -> Stage:
    """Return what comes after an accepted dwell; ``again`` makes the usual stage, told why the cube is to move."""
    for dwells, error in context.turned_off():
        names = {dwell.name: dwell for dwell in sorted(dwells, key=lambda each: (each.position, each.repeat))}
        dwell = names.get(context.checklist.latest, dwells[0])  # where it may be several
        if (key := tuple(names)) in context.reported_turned or context.checklist.step(dwell.name) is None:
            continue
        context.reported_turned.add(key)
        told = f"position {' or '.join(each.words for each in names.values())} {heading_error_text(error)}"
        context.event_log.say("rejected", told)
        if not context.bench.asks:  # once: the second time it stands as it is, and the solution says so
            return (
                _redo(context, dwell, error, again) if context.checklist.attempts[dwell.name] == 1 else again("")
            )
        then = {REDO: partial(_redo, context, dwell, error, again), KEEP: partial(again, "")}
        choices = (
            Choice(key=REDO, title=f"record position {dwell.words} again, set along the marks"),
            Choice(key=KEEP, title="keep it: the solution lists it, the uncertainties do not include it"),
        )
        return QuestionStage(
            context, OperatorQuestion(text=f"{told[0].upper()}{told[1:]}.", choices=choices), then
        )
    return again("")


def _redo(context: StageContext, dwell: Dwell, error: HeadingError, again: Callable[[str], Stage]) -> Stage:
    context.checklist.redo(dwell.name)
    way = "counter-clockwise" if error.angle > 0 else "clockwise"
    return again(f"set position {dwell.words} along the marks: it was too far {way}")

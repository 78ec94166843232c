"""The seats of dwells that stand, judged anew: what they were judged by may have been wrong.

A cube on a crumb that nobody noticed, as the first on its face, makes clean seats after it look tilted. A seat
that comes back the same after lifting, farther off than any bench is, therefore speaks against what it is judged
by as much as against itself: both are marked, what it is judged by is recorded again, and those that were marked
are then judged by that.
"""

from procedures.bench.seating_check import Seating, judge
from procedures.campaign.plan_steps import Dwell
from station.guide.accepted_dwell import AcceptedDwell
from station.guide.instruction_words import step_title
from station.guide.seating_watch import SHARP_RAD, SeatCheck, compared
from station.guide.stage_context import StageContext


def judge_seats_anew(context: StageContext, step: Dwell, seat: SeatCheck) -> None:
    """Judge the seats that stand, after ``step`` was accepted on ``seat``."""
    if seat.came_back is not None:
        now = context.accepted_dwells[step.name]
        for each in _suspects(context, now):
            context.mark_seat(each.step, -seat.came_back)
            _ask_again(context, each, now)
    elif context.checklist.attempts[step.name] > 1:
        for name in sorted(context.badly_seated & context.accepted_dwells.keys() - {step.name}):
            _clear(context, context.accepted_dwells[name])


def _suspects(context: StageContext, now: AcceptedDwell) -> list[AcceptedDwell]:
    """Return what the one accepted ``now`` may have been wrongly judged by.

    First what else stood on its face; if that was asked for again already, or is of an earlier turn-on, all
    without which it would not be off.
    """
    there = [each for each in context.well_seated if each.face == now.face]
    if there and not all(each.step.name in context.seats_asked_again for each in there):
        return there
    found = [each for each in context.well_seated if not _is_off(_by_others(context, now, each.step.name))]
    return found or [each for each, _ in context.earlier_dwells if each.face == now.face]


def _by_others(context: StageContext, dwell: AcceptedDwell, without: str = "") -> Seating | None:
    """Return how a dwell sits by the others, ``without`` that one; None where they do not say."""
    now = dwell.position, dwell.accel, dwell.accel_std
    return compared(context, now, is_again=False, without={without, dwell.step.name})


def _is_off(seating: Seating | None) -> bool:
    return seating is not None and bool(judge(seating))


def _ask_again(context: StageContext, dwell: AcceptedDwell, now: AcceptedDwell) -> None:
    """Ask for a dwell once more, but not for ever: a second time it stays marked, and the verdict says so."""
    name = dwell.step.name
    if name in context.seats_asked_again or not context.checklist.redo(name):
        return
    context.seats_asked_again.add(name)
    why = f"{step_title(now.step)} came back the same after lifting, so that it or this one stood on something"
    context.event_log.say("rejected", f"{step_title(dwell.step)} is to be recorded again: {why}")


def _clear(context: StageContext, dwell: AcceptedDwell) -> None:
    """Take the mark from a dwell that sits well by the others, if they know it well enough to tell a crumb."""
    found, name = _by_others(context, dwell), dwell.step.name
    if found is None or found.std.max() > SHARP_RAD or _is_off(found):
        return
    context.mark_seat(dwell.step, None)
    if name in context.seats_asked_again:
        context.checklist.keep(name)
    context.event_log.say("", f"{step_title(dwell.step)} sat well: what it was compared with did not")

"""The seats of dwells that stand, judged anew: what they were judged by may have been wrong.

A cube on a crumb that nobody noticed, as the first on its face, makes clean seats after it look tilted. A seat
that comes back the same after lifting, farther off than any bench is, therefore speaks against what it is judged
by as much as against itself: both are marked, what it is judged by is recorded again, and those that were marked
are then judged by that. What is marked is found before a step is accepted, so that both are written at once: a
kill leaves either all of it or nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from procedures.arrays import FloatArray
from procedures.bench.seating_check import Seating, judge
from procedures.campaign.plan_steps import Dwell, Step
from station.guide.accepted_dwell import AcceptedDwell
from station.guide.instruction_words import step_title
from station.guide.seating_watch import SHARP_RAD, SeatCheck, compared
from station.guide.stage_context import StageContext
from station.stream.recorder.sample_buffer import SampleRun


@dataclass(frozen=True, eq=False)
class _Standing:
    """The dwells that stand, by step, which of them are known to sit badly, and those of earlier turn-ons."""

    context: StageContext
    dwells: Mapping[str, AcceptedDwell]
    bad: frozenset[str]
    earlier: Sequence[tuple[AcceptedDwell, int]]

    @property
    def well_seated(self) -> list[AcceptedDwell]:
        return [each for name, each in self.dwells.items() if name not in self.bad]

    def by_others(self, dwell: AcceptedDwell, without: str = "") -> Seating | None:
        """Return how a dwell sits by the others, ``without`` that one; None where they do not say."""
        left_out, now = {without, dwell.step.name}, (dwell.position, dwell.accel, dwell.accel_std)
        known = [(each, 0) for each in self.well_seated if each.step.name not in left_out]
        return compared(self.context.bench, [*known, *self.earlier], now, is_again=False)


def seats_anew(
    context: StageContext, step: Dwell, runs: Sequence[SampleRun], seat: SeatCheck
) -> dict[Dwell, FloatArray | None]:
    """Judge the seats that stand as if ``step`` were accepted on ``seat``, as the samples of ``runs``.

    Returns those that are to be marked, by how far off (2,) [rad] they sit; None: well after all.
    """
    is_again = bool(context.checklist.attempts[step.name])
    if seat.came_back is None and not (is_again and context.badly_seated - {step.name}):
        return {}
    now = context.dwell_of(step, runs)
    standing = _Standing(
        context,
        context.accepted_dwells | {step.name: now},
        frozenset(context.badly_seated - {step.name} | ({step.name} if seat.is_off else set())),
        [each for each in context.earlier_dwells if each[0].step.name != step.name],
    )
    if seat.came_back is None:
        return dict.fromkeys(_cleared(standing, but=step.name))
    suspects = _suspects(standing, now, context.seats_asked_again)
    return {each.step: _lean(standing, each, now, seat.came_back) for each in suspects}


def ask_again(context: StageContext, step: Step, marked: Mapping[Dwell, FloatArray | None]) -> None:
    """Ask for what was ``marked``, by how much its cube sat off (3,) [rad], once more, None where it sat well.

    Not for ever: a second time it stays so, and the verdict says it.
    """
    for each, off in marked.items():
        is_asked = each.name in context.seats_asked_again
        if off is None:
            if is_asked:
                context.checklist.keep(each.name)
            context.event_log.say(
                "", f"{step_title(each)} was seated correctly: the recording it was compared with was not"
            )
        elif not is_asked and context.checklist.redo(each.name):
            context.seats_asked_again.add(each.name)
            why = (
                f"{step_title(step)} gave the same result after lifting, so there was debris under one of the two"
            )
            context.event_log.say("rejected", f"{step_title(each)} will be recorded again: {why}")


def _suspects(standing: _Standing, now: AcceptedDwell, asked_again: set[str]) -> list[AcceptedDwell]:
    """Return what the one accepted ``now`` may have been wrongly judged by.

    First what else stood on its face; if that was asked for again already, or is of an earlier turn-on, all
    without which it would not be off.
    """
    there = [each for each in standing.well_seated if each.face == now.face]
    if there and not all(each.step.name in asked_again for each in there):
        return there
    found = [each for each in standing.well_seated if not _is_off(standing.by_others(now, each.step.name))]
    return found or [each for each, _ in standing.earlier if each.face == now.face]


def _lean(standing: _Standing, dwell: AcceptedDwell, now: AcceptedDwell, off: FloatArray) -> FloatArray:
    """Return how far off (2,) [rad] a dwell sits where the one accepted ``now``, found ``off``, sits well.

    On the same face the one is off as the other is, the other way round; on another it is by a tilt of its own
    that they tell of it, or, where they tell nothing, by as much.
    """
    if dwell.face == now.face:
        return -off
    found = replace(standing, bad=standing.bad - {now.step.name}).by_others(dwell)
    return off if found is None else found.off


def _cleared(standing: _Standing, but: str) -> list[Dwell]:
    """Return the marked dwells that sit well by the others, if they know it well enough to tell a crumb."""
    cleared = list[Dwell]()
    for name in sorted(standing.bad & standing.dwells.keys() - {but}):
        found = standing.by_others(standing.dwells[name])
        if found is not None and found.std.max() <= SHARP_RAD and not _is_off(found):
            standing = replace(standing, bad=standing.bad - {name})
            cleared.append(standing.dwells[name].step)
    return cleared


def _is_off(seating: Seating | None) -> bool:
    return seating is not None and bool(judge(seating))

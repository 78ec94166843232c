"""Is the cube seated as the dwells before it predict? Checked while the operator is still near.

Debris or a hair under the cube tilts it by tens of arcseconds. A tilt that is the same after lifting, wiping and
setting down is the bench's: it is accepted. Where it is farther off than any bench is, it speaks against the
earlier dwells as much as against itself: both are marked, the earlier ones are recorded again, and the marked ones
are then compared with those. All marks are written together with the step: a kill leaves either all of them or
none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.seating_check import (
    MIN_TILT_SIGMAS,
    PLAUSIBLE_FACE_TILT_RAD,
    PositionRates,
    Seating,
    judge,
    seating,
)
from procedures.campaign.plan_steps import Dwell, Step, Turn
from procedures.units import ARCSEC_PER_DEG, RAD_PER_ARCSEC
from station.guide.campaign.accepted_steps import AcceptedDwell, rates_and_sigmas
from station.guide.checks.dwell_attempt import DwellAttempt
from station.guide.setup_view import Choice
from station.guide.stages.stage_context import BenchFacts, StageContext
from station.guide.view import OperatorQuestion
from station.guide.wording import step_title
from station.stream.live.stillness import Block, runs_of_blocks
from station.stream.recorder.sample_buffer import SampleRun

LOOKS_S = (3.0, 6.0, 10.0, 20.0, 40.0, 70.0)  # of accepted seconds
ALIKE_RAD = 5e-5  # 10 arcsec, or three sigma
KEPT_SHARE = 0.2  # of a kept seat's tilt: by so much it may move as it is let go
FIRST_ON_FACE = "first placement on this face: nothing to compare with yet"
FIRST_SINCE_ON = "first placement on this face since power-on: not checked yet"
SHARP_RAD = 3e-4  # rad, 1 sigma: debris of 0.1 deg is detected
CONTRADICTORY = "not checked: the earlier placements contradict each other"


class SeatCheck:
    """Judges the seat of one attempt at a dwell on ``face``; or, where it is none ``is_again``, of a turn."""

    def __init__(self, context: StageContext, face: str, *, is_again: bool = True) -> None:
        self._context, self.face, self._is_again = context, face, is_again
        self._looks = list(LOOKS_S)
        self.words, self.is_off = "", False
        self.is_to_lift = False  # off, and neither kept nor the bench's
        self.is_sharp = False  # known well enough to detect debris
        self.came_back: FloatArray | None = None  # (2,) [rad]: just so after lifting, by more than a face may be
        self._off: FloatArray | None = None  # as it was last found

    @property
    def kept(self) -> FloatArray | None:
        """How far off (2,) [rad] the cube sits that the operator takes so; None where it sits well."""
        return self._off if self.is_off else None

    def fault(self, dwelling: DwellAttempt, position: int) -> str:
        """Look when it is time to; return why the cube should be lifted, empty if it need not."""
        if not position or not self._looks or dwelling.accepted_s < self._looks[0]:
            return ""
        while self._looks and dwelling.accepted_s >= self._looks[0]:
            self._looks.pop(0)
        return self.judged(dwelling.runs(), position)

    def judged(self, runs: Sequence[SampleRun], position: int) -> str:
        """Look at what ``runs`` hold; return why the cube should be lifted, empty if it need not."""
        context, self.came_back = self._context, None
        now = [each for each in context.well_seated if each.position != position or not self._is_again]
        if not any(each.face == self.face for each in (*now, *(each for each, _ in context.earlier_dwells))):
            return self._not_judged(FIRST_ON_FACE)
        accel, std = rates_and_sigmas(context.accel_rates(runs))
        found = compared(context.bench, context.judges, (position, accel, std), is_again=self._is_again)
        if found is None:
            return self._not_judged(CONTRADICTORY)
        why = judge(found)
        self.is_sharp = bool(found.std.max() < SHARP_RAD)
        if not why and not self.is_sharp and not any(each.face == self.face for each in now):
            return self._not_judged(FIRST_SINCE_ON)
        self.is_off, self._off = bool(why), found.off
        arcsec = np.degrees(np.abs(found.off).max()) * ARCSEC_PER_DEG
        self.words = why or f"seating error within {arcsec:.0f} arcsec"
        self.is_to_lift = False
        if why and self._is_kept(position, found):
            self.words = f"kept: {why}"
            return ""
        if not why or self._is_known(position, found):
            return ""
        self.is_to_lift = True
        context.seats[position], context.off_seat = found.off, position
        return f"not seated: {why}; lift, wipe, set down"

    def _not_judged(self, why: str) -> str:
        self.is_to_lift = False
        self.words, self.is_off, self._off = why, False, None
        return ""

    def _is_kept(self, position: int, found: Seating) -> bool:
        """Say whether this is the seat that the operator keeps, and not another one."""
        if (kept := self._context.kept_seats.get(position)) is None:
            return False
        near = max(ALIKE_RAD, 3 * float(found.measured_std.max()), KEPT_SHARE * float(np.linalg.norm(kept)))
        return bool(np.linalg.norm(found.off - kept) < near)

    def _is_known(self, position: int, found: Seating) -> bool:
        """Say whether the cube sat just so before it was lifted: then it is the bench."""
        if (before := self._context.seats.get(position)) is None:
            return False
        near = np.maximum(ALIKE_RAD, 3 * found.measured_std)
        if alike := bool(np.all(np.abs(found.off - before) < near)):
            # no cube's own face is tilted by more: this seat or one before it is wrong, and the verdict says so
            self.is_off = bool(np.linalg.norm(found.off) > PLAUSIBLE_FACE_TILT_RAD)
            self.came_back = found.off if self.is_off else None
            self.words = "the same after lifting: accepted"
        return alike


def compared(
    bench: BenchFacts, known: Sequence[tuple[AcceptedDwell, int]], now: PositionRates, *, is_again: bool
) -> Seating | None:
    """Compare how the cube sits with dwells that are ``known``, each with its turn-on, 0 being the present one."""
    before, turn_ons = [(each.position, each.accel, each.accel_std) for each, _ in known], [on for _, on in known]
    return seating(before, now, bench.fixture, bench.heading_std, turn_ons=turn_ons, is_again=is_again)


def keep_question(context: StageContext) -> OperatorQuestion | None:
    """Return what is to be asked before the cube is kept as it sits; None where that is plausible."""
    off = float(np.linalg.norm(context.seats[context.off_seat]))
    if off <= PLAUSIBLE_FACE_TILT_RAD:
        return None
    text = (
        f"The cube is tilted by {np.degrees(off):.2f} deg. A clean seating is not tilted so much. If you keep it, "
        f"it is recorded as tilted and the calibration will be wrong. Keep it?"
    )
    no, yes = Choice(key="n", title="no: lift, wipe, place again"), Choice(key="y", title="yes, keep this seating")
    return OperatorQuestion(text=text, choices=(no, yes))


def rest_rates(context: StageContext, position: int, blocks: list[Block]) -> PositionRates:
    """Return the accelerometers' rates at rest over ``blocks``, and their sigmas."""
    return position, *rates_and_sigmas(context.accel_rates(runs_of_blocks(blocks, None)))


def tilt_change(before: PositionRates, after: PositionRates) -> str:
    """Say by how much the cube lies otherwise after a turn than before it; empty if it does not.

    After whole revolutions slab, face, bias and misalignment are the same as before: only noise may differ.
    """
    up = int(np.argmax(np.abs(before[1])))
    per_g, level = np.abs(before[1][up]), [i for i in range(3) if i != up]
    off = (after[1] - before[1])[level] / per_g
    limit = np.maximum(MIN_TILT_SIGMAS * np.hypot(before[2], after[2])[level] / per_g, ALIKE_RAD)
    if np.all(np.abs(off) <= limit):
        return ""
    return f"the cube is tilted by {np.linalg.norm(off) / RAD_PER_ARCSEC:.0f} arcsec against its earlier seating"


def remember_rests(context: StageContext, step: Turn, before: PositionRates, after: PositionRates) -> None:
    """Remember a turn's rests until there are dwells to judge them by."""
    mean = (before[1] + after[1]) / 2
    context.turn_rests[step.name] = before[0], mean, np.hypot(before[2], after[2]) / 2


def reject_tilted_turns(context: StageContext) -> None:
    """Have the turns done again in which the cube lay tilted, as dwells accepted since then show."""
    for name, rest in list(context.turn_rests.items()):
        step, found = context.checklist.step(name), compared(context.bench, context.judges, rest, is_again=False)
        if isinstance(step, Turn) and found is not None and (why := judge(found)) and context.checklist.redo(name):
            del context.turn_rests[name]
            context.event_log.say("rejected", f"{step_title(step)}: the cube was {why}; lift, wipe, rotate again")


@dataclass(frozen=True, eq=False)
class _StandingDwells:
    """The accepted dwells by step, which of them are known to be badly seated, and those of earlier turn-ons."""

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


def recheck_seats(
    context: StageContext, step: Dwell, runs: Sequence[SampleRun], seat: SeatCheck
) -> dict[Dwell, FloatArray | None]:
    """Judge the seats that stand as if ``step`` were accepted on ``seat``, as the samples of ``runs``.

    Returns those that are to be marked, by how far off (2,) [rad] they sit; None: well after all.
    """
    is_again = bool(context.checklist.attempts[step.name])
    if seat.came_back is None and not (is_again and context.badly_seated - {step.name}):
        return {}
    now = context.dwell_of(step, runs)
    bad = frozenset(context.badly_seated - {step.name} | ({step.name} if seat.is_off else set()))
    earlier = [each for each in context.earlier_dwells if each[0].step.name != step.name]
    standing = _StandingDwells(context, context.accepted_dwells | {step.name: now}, bad, earlier)
    if seat.came_back is None:
        return dict.fromkeys(_cleared(standing, but=step.name))
    suspects = _suspects(standing, now, context.seat_repeats)
    return {each.step: _tilt_of(standing, each, now, seat.came_back) for each in suspects}


def repeat_marked(context: StageContext, step: Step, marked: Mapping[Dwell, FloatArray | None]) -> None:
    """Ask for what was ``marked``, by how much its cube sat off (3,) [rad], once more, None where it sat well.

    Not for ever: a second time it stays so, and the verdict says it.
    """
    for each, off in marked.items():
        is_asked = each.name in context.seat_repeats
        if off is None:
            if is_asked:
                context.checklist.keep(each.name)
            found = "was seated correctly: the recording it was compared with was not"
            context.event_log.say("", f"{step_title(each)} {found}")
        elif not is_asked and context.checklist.redo(each.name):
            context.seat_repeats.add(each.name)
            why = (
                f"{step_title(step)} gave the same result after lifting, so there was debris under one of the two"
            )
            context.event_log.say("rejected", f"{step_title(each)} will be recorded again: {why}")


def _suspects(standing: _StandingDwells, now: AcceptedDwell, asked_again: set[str]) -> list[AcceptedDwell]:
    """Return what the one accepted ``now`` may have been wrongly judged by.

    First what else stood on its face; if that was asked for again already, or is of an earlier turn-on, all
    without which it would not be off.
    """
    there = [each for each in standing.well_seated if each.face == now.face]
    if there and not all(each.step.name in asked_again for each in there):
        return there
    found = [each for each in standing.well_seated if not _is_off(standing.by_others(now, each.step.name))]
    return found or [each for each, _ in standing.earlier if each.face == now.face]


def _tilt_of(standing: _StandingDwells, dwell: AcceptedDwell, now: AcceptedDwell, off: FloatArray) -> FloatArray:
    """Return how far off (2,) [rad] a dwell sits where the one accepted ``now``, found ``off``, sits well.

    On the same face the one is off as the other is, the other way round; on another it is by a tilt of its own
    that they show, or, where they show nothing, by as much.
    """
    if dwell.face == now.face:
        return -off
    found = replace(standing, bad=standing.bad - {now.step.name}).by_others(dwell)
    return off if found is None else found.off


def _cleared(standing: _StandingDwells, but: str) -> list[Dwell]:
    """Return the marked dwells that sit well by the others, if they determine it well enough to detect debris."""
    cleared = list[Dwell]()
    for name in sorted(standing.bad & standing.dwells.keys() - {but}):
        found = standing.by_others(standing.dwells[name])
        if found is not None and found.std.max() <= SHARP_RAD and not _is_off(found):
            standing = replace(standing, bad=standing.bad - {name})
            cleared.append(standing.dwells[name].step)
    return cleared


def _is_off(seating: Seating | None) -> bool:
    return seating is not None and bool(judge(seating))

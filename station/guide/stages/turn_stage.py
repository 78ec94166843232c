"""A manual rotation: rest, rotation, rest; counted live, and accepted once the cube is back at its start."""

from typing import Any

import numpy as np

from procedures.bench.seating_check import TurnCounts
from procedures.campaign.plan_steps import Turn
from procedures.frames import AXES
from procedures.gyrocompass import CertainDwell, rough_scale_factor
from procedures.positions import face_of
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.checks.seating import SeatCheck, remember_rests, rest_rates, tilt_change
from station.guide.checks.turn_closure import (
    GROSS_SIGMAS,
    TURN_AGAIN,
    WIDEN_CLOSURE,
    agreement_in_words,
    earth_rate_text,
    heading_moved,
)  # fmt: skip
from station.guide.stages.stage import NEITHER, OTHER_WAY, TAKE, NextStage, Stage, which_position, which_turn
from station.guide.stages.stage_context import StageContext
from station.guide.view import OperatorQuestion, TurnView
from station.guide.wording import rest_before, step_title, times_in_words, turn_instruction, turn_sense
from station.stream.live.rotation_detection import RotationDetector
from station.stream.live.stillness import Block, runs_of_blocks

TOUCHED_REVOLUTIONS = 0.1  # less is no turn, but a hand on the cube
BACK_REVOLUTIONS = 0.2  # short of all: by so much a scale factor from the Earth rate may be off
SLOW_DEG_S, FAST_DEG_S = 5.0, 100.0


class TurnStage(Stage):
    """One attempt at the turn ``step``, the cube resting on its face."""

    def __init__(self, context: StageContext, step: Turn, again: NextStage) -> None:
        super().__init__(context)
        self._step, self._again = step, again
        self._watch = RotationDetector(step, context.C_sb, context.feed.period, context.turn_counts)
        self._position = context.position
        self._rested: list[Block] = []
        self._is_ready = False
        self._is_answered = False  # what is to become of turns that did not close
        self._takes_other: bool | None = None  # a turn the wrong way as the other step, as the operator says
        self._is_touched = False  # moved again while that is asked
        self._is_back = False  # it made its revolutions, and rested then
        self._seat = SeatCheck(context, face_of(step.start_position), is_again=False)

    @property
    def oldest(self) -> int | None:
        return self._watch.first.first if self._watch.first else None

    @property
    def is_moving(self) -> bool:
        """Whether the turn is under way."""
        return self._watch.is_moving

    def take(self, block: Block, look: BlockLook) -> Stage:
        if not self._context.checklist.is_open(self._step):  # its closure is stated as it was found
            return self._again("", must_move=True)
        if self._is_ready:
            return self._follow(block, look)
        if look.hindrance:
            return self._again("", must_move=False)
        self._watch.rest(block)
        self._rested.append(block)
        if why := self._wrong_heading():
            return self._again(why, must_move=True)
        if self._position and self._is_rested:
            if why := self._seat.judged(runs_of_blocks(self._watch.rests[0], None), self._step.start_position):
                return self._again(why, must_move=True)
            self._is_ready = True
            how = f"{times_in_words(self._step)} {turn_sense(self._step)}"
            self._context.event_log.say("start", f"turn now: {how}")
        return self

    def interrupted(self) -> Stage:
        self._context.position = 0
        return self._again("the data stream was interrupted; the rotation starts again", must_move=False)

    def answer(self, key: str) -> None:
        """Take the operator's word for the position, or for what becomes of turns that did not close."""
        if self._asks_of_closing and key in {TURN_AGAIN, WIDEN_CLOSURE}:
            self._is_answered = True
            if key == WIDEN_CLOSURE:
                self._context.widen_closure(self._step.axis)
            return
        if self._is_wrong_way and key in OTHER_WAY:
            self._takes_other = key == TAKE
            return
        if key in {choice.key for choice in which_position(face_of(self._step.start_position)).choices}:
            self._position = -1 if key == NEITHER else int(key)

    def shown(self) -> dict[str, Any]:
        watch = self._watch
        per_degree = self._gyro_k * np.pi / 180
        turn = TurnView(
            revolutions=0.0 if self._is_wrong_way else self._revolutions(),
            wanted=self._step.revolutions,
            speed_deg_s=abs(watch.count_rate) / per_degree if watch.is_moving else 0.0,
            slow_deg_s=SLOW_DEG_S, fast_deg_s=FAST_DEG_S,
            rest_s=watch.rested_s, rest_wanted_s=float(watch.rest_blocks), may_begin=self._is_ready,
            is_back=self._is_back,
        )  # fmt: skip
        line, hint = turn_instruction(self._step), ""
        if not self._is_ready:
            line = rest_before(self._step)
        elif self._is_back:
            line = f"hands off: the cube rests after {step_title(self._step)}"
        elif watch.is_moving:
            line = f"{step_title(self._step)}: {abs(turn.revolutions):.2f} of {turn.wanted} turns"
            hint = _speed(turn) if not watch.rested_s else "continue the rotation without a rest"
            if self._is_wrong_way:
                hint = f"wrong direction: turn {turn_sense(self._step)}, seen from above"
        return {
            "stage": "turn", "live": self._step.name, "line": line, "hint": hint, "turn": turn,
            "question": self._question, "gates": {"position": self._position, "seating": self._seat.words},
        }  # fmt: skip

    @property
    def _asks_of_closing(self) -> bool:
        """Whether the operator may state a wider closure instead of turning again; turning answers as well."""
        context, is_free = self._context, not self._is_answered and not self._watch.is_moving
        return context.bench.asks and is_free and context.closings.is_open(self._step.axis)

    @property
    def _question(self) -> OperatorQuestion | None:
        if self._asks_of_closing:
            return self._context.closings.question(self._step.axis)
        asks = self._context.bench.asks
        if asks and self._is_wrong_way and self._takes_other is None and (other := self._other):
            return which_turn(self._step, other)
        if self._position or not asks or not self._is_rested:
            return None
        return which_position(face_of(self._step.start_position))

    @property
    def _is_rested(self) -> bool:
        return self._watch.rested_s >= self._watch.rest_blocks - 0.5

    @property
    def _is_round(self) -> bool:
        """Whether it has made its revolutions; where no scale factor is known a rest alone says so."""
        if self._context.gyro_k is None:
            return True
        return abs(self._revolutions()) >= self._step.revolutions - BACK_REVOLUTIONS

    def _wrong_count(self) -> str:
        """Say whether the Earth's rate shows another number of revolutions; only for the first turn."""
        context, wanted = self._context, self._step.revolutions
        if context.turns:
            return ""
        found = abs(self._revolutions())
        k = rough_scale_factor(context.known, context.bench.latitude, context.C_sb)
        if k is None or round(found) == wanted:
            return ""
        return f"about {found:.1f} revolutions were made, expected {wanted}"

    def _revolutions(self) -> float:
        """Return how far it has turned since it began to move."""
        watch = self._watch
        return watch.turned_counts / (2 * np.pi * self._gyro_k) if watch.is_moving else 0.0

    @property
    def _gyro_k(self) -> float:
        """The gyros' scale factor [count/rad], roughly."""
        return self._context.rough_gyro_k(self._watch.rest_rate)

    def _wrong_heading(self) -> str:
        """Find where the cube stands; say what is wrong with it."""
        context, step = self._context, self._step
        if not self._position:
            rate = np.mean([block.rate[:3] for block in self._rested], axis=0)
            found = context.heading(rate, len(self._rested), face_of(step.start_position))
            if found.is_sure:
                self._position = found.position or -1
            elif not context.bench.asks and self._is_rested:
                self._position = step.start_position
        if self._position in {0, step.start_position}:
            return ""
        where = f"position {self._position}" if self._position > 0 else "no position, 90 deg off the marks"
        return f"the cube is in {where}; {step_title(step)} starts in position {step.start_position}"

    def _follow(self, block: Block, look: BlockLook) -> Stage:
        context, watch = self._context, self._watch
        if watch.is_over:  # it waits for an answer
            self._is_touched |= not look.is_still
        else:
            watch.take(block, is_still=look.is_still)
        if watch.is_moving:
            context.moved()
            self._is_back |= bool(watch.rested_s) and self._is_round
        if self._is_wrong_way and (why := self._other_way()):
            return self._again(why, must_move=False)
        if self._is_wrong_way:
            return self
        if look.is_still and look.face != face_of(self._step.start_position):
            return self._repeated("the cube was tipped over")
        return self._over() if watch.is_over else self

    def _over(self) -> Stage:
        """Judge the whole turn."""
        context, watch = self._context, self._watch
        if abs(self._revolutions()) < TOUCHED_REVOLUTIONS:
            context.event_log.say("still", "touched before the rotation: keep your hands off")
            return self._again("", must_move=False)
        if why := watch.fault() or self._wrong_count():
            return self._repeated(why)
        change = self._heading_moved()
        closure_deg = np.degrees(context.closings.closure_std)
        if change is not None and abs(change[0]) > GROSS_SIGMAS * np.hypot(change[1], closure_deg):
            return self._repeated(f"closure error {abs(change[0]):.1f} deg (u = {change[1]:.1f} deg)")
        before, after = (rest_rates(context, self._step.start_position, each) for each in self._rests)
        if why := tilt_change(before, after):
            return self._again(f"{step_title(self._step)}: {why}; lift, wipe, rotate again", must_move=True)
        seen = self._seen()
        partner = context.closings.partner(self._step.axis, self._step.direction)
        note = agreement_in_words(seen, partner, context.closings.closure_std) or earth_rate_text(change)
        context.accept_turn(self._step, runs_of_blocks(watch.step_blocks(), None), seen, note)
        if not self._seat.is_sharp:
            remember_rests(context, self._step, before, after)
        context.position = 0 if self._is_touched else self._step.start_position
        return self._again("", must_move=not self._is_touched)

    def _repeated(self, why: str) -> Stage:
        return self._again(f"{step_title(self._step)}: {why}; repeat", must_move=False)

    @property
    def _is_wrong_way(self) -> bool:
        turned = self._revolutions()
        is_other = abs(turned) > TOUCHED_REVOLUTIONS and (turned > 0) != (self._step.direction == "+")
        return is_other and self._watch.is_about_axis

    @property
    def _other(self) -> Turn | None:
        """The turn the other way, if it is to be done as well."""
        checklist, step = self._context.checklist, self._step
        alike = (step.axis, step.start_position, step.revolutions)
        turns = [s for s in checklist.steps if isinstance(s, Turn) and s != step and checklist.is_open(s)]
        return next((s for s in turns if (s.axis, s.start_position, s.revolutions) == alike), None)

    def _other_way(self) -> str:
        """Take a turn the wrong way as the other step if it may be that; say why it may not."""
        other = self._other
        if other is None or self._takes_other is False:
            expected = f"expected {turn_sense(self._step)} seen from above"
            return f"{step_title(self._step)}: wrong direction, {expected}; repeat"
        if self._takes_other or not self._context.bench.asks:
            self._context.event_log.say("", f"taken as {step_title(other)}")
            self._step = other
            self._watch.take_as(other)
        return ""

    def _seen(self) -> TurnCounts:
        """Return the turn as it counted; its noise is that of the rate at rest, over the time it moved."""
        step, watch, context = self._step, self._watch, self._context
        up = context.C_sb[:, AXES.index(step.axis)]
        rate_std = float(np.sqrt(up**2 @ context.gyro_std(len(watch.rests[0])) ** 2))
        angle = 2 * np.pi * step.revolutions
        noise = rate_std * watch.moved_s / abs(watch.turned_counts) * angle
        return TurnCounts(step.direction, watch.counts_per_revolution, angle, noise)

    @property
    def _rests(self) -> tuple[list[Block], list[Block]]:
        """The blocks surely at rest: a slow end of the turn would leak into level gyros."""
        before, after = self._watch.rests
        return before[:-1], after[1:]

    def _heading_moved(self) -> tuple[float, float] | None:
        """Return the heading change from the horizontal Earth rate before and after [deg], with 1 sigma."""
        context, (before, after) = self._context, self._rests
        if not before or not after:
            return None
        known = self._known(before), self._known(after)
        return heading_moved(*known, context.bench.latitude, context.C_sb, self._gyro_k)

    def _known(self, blocks: list[Block]) -> CertainDwell:
        rate = np.mean([block.rate[:3] for block in blocks], axis=0)
        return CertainDwell(self._step.start_position, rate, self._context.gyro_std(len(blocks)))


def _speed(turn: TurnView) -> str:
    if turn.speed_deg_s > turn.fast_deg_s:
        return "slower"
    return "faster" if 0 < turn.speed_deg_s < turn.slow_deg_s else ""

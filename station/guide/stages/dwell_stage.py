"""Dwells, soaks and rests in free attitudes: accepted seconds are counted, heading and seating are checked.

The heading is determined from the Earth rate, a free attitude by the accelerometers: it lies between faces, apart
from those recorded before.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import SHORTEST_S
from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak
from procedures.free_positions.free_attitudes import MIN_APART_DEG, nearest_deg
from procedures.gyrocompass import quarters_to, turned_position
from procedures.positions import face_normal, position_name
from station.guide.checks.dwell_attempt import TOUCHED, DwellAttempt, crept
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.checks.seating import SeatCheck, recheck_seats, reject_tilted_turns, repeat_marked
from station.guide.stages.stage import NEITHER, NextStage, Stage, after_dwell, which_position
from station.guide.stages.stage_context import StageContext
from station.guide.view import OperatorQuestion, SoakView
from station.guide.wording import soak_in_words, step_title
from station.stream.live.stillness import Block

FaceStep = Dwell | Soak | Monitor
RestStep = FaceStep | FreePosition
ASK_AFTER_S = 10.0  # of accepted seconds without a sure heading
BY_EARTH, AS_ANSWERED, AS_ASKED = "from the Earth rate", "as you answered", "as requested, not checked"
ANY_HEADING = "any heading"
QUARTERS = {1: "90 deg more, counter-clockwise", 2: "180 deg more", 3: "90 deg more, clockwise"}


class RestRecording(Stage):
    """What a dwell on a face and a rest in a free attitude share: one attempt, its accepted seconds, its soak."""

    def __init__(self, context: StageContext, step: RestStep, again: NextStage) -> None:
        super().__init__(context)
        self._again, self._is_soak = again, isinstance(step, Soak | Monitor)
        period = context.feed.period
        samples = round(step.seconds / period)
        self._dwelling = DwellAttempt(samples, period, context.rough_gyro_k, drifts=self._is_soak)
        self._temperatures: list[float] = []  # [degC] of a device that says them
        self._shows_soak = isinstance(step, Soak)
        context.event_log.say("start", "recording: keep your hands off")

    @property
    def oldest(self) -> int | None:
        return self._dwelling.oldest

    def _restarted(self, block: Block, look: BlockLook) -> Stage | None:
        """Take a second of the stream; return the stage that starts again, None while this one continues."""
        was_disturbed = self._dwelling.is_disturbed
        if not math.isnan(block.temperature):
            self._temperatures.append(block.temperature)
        if why := self._dwelling.take(block, look):
            if why == TOUCHED:
                self._context.event_log.say("still", "the cube is still touched: keep your hands off")
                return self._again("", must_move=False)
            if self._dwelling.is_turned and self._is_along_marks:
                return self._again(f"{why}; lift it and set it along the marks", must_move=True)
            return self._again(f"{why}; the recording starts again", must_move=False)
        if self._dwelling.is_disturbed and not was_disturbed and not self._dwelling.is_early:
            self._context.event_log.say("still", "disturbed: keep still, only the affected seconds are discarded")
        return None

    @property
    def _is_along_marks(self) -> bool:
        """Whether it matters which way the cube points, which the marks on the surface plate define."""
        return False

    def _progress(self, step: RestStep, where: str) -> dict[str, Any]:
        """Return the fields of a view that say how far it is."""
        accepted_s = min(self._dwelling.accepted_s, step.seconds)
        soak = SoakView(left_s=step.seconds - accepted_s) if self._shows_soak else None
        if soak and (seen := self._temperatures):
            now = {"temperature_c": seen[-1], "low_c": min(seen), "high_c": max(seen)}
            soak = soak.model_copy(update=now)
        line = f"{where}: {accepted_s:.0f} of {step.seconds:.0f} s, hands off"
        return {
            "stage": "dwell", "live": step.name, "accepted_s": accepted_s, "wanted_s": step.seconds,
            "hint": "disturbed: affected seconds are discarded; keep still" if self._dwelling.is_disturbed else "",
            "line": f"{line}; {soak_in_words(soak)}" if soak else line, "soak": soak,
        }  # fmt: skip

    def _crept(self) -> str:
        """Say how far the cube crept; not of a soak, whose slope is looked for."""
        if self._is_soak:
            return ""
        context, dwelling = self._context, self._dwelling
        return crept(context.accel_rates(dwelling.runs()), dwelling.accepted_s, context.C_sb @ self._up)

    def _completed(self) -> Stage:
        """Return the stage after enough accepted seconds: this one if some of them do not count after all."""
        self._dwelling.drop_unstill(self._context.gate.stillness.is_still)
        if not self._dwelling.is_complete:
            return self
        if why := self._crept():
            return self._again(f"{why}; the recording starts again", must_move=False)
        return self._accepted()

    def _accepted(self) -> Stage:
        """Accept the step, if nothing else is against it; return the stage that goes on."""
        raise NotImplementedError

    @property
    def _up(self) -> FloatArray:
        """The unit vector (3,) that points up, in cube axes."""
        raise NotImplementedError


class DwellStage(RestRecording):
    """One attempt at a dwell or soak on ``face``, for one of ``dwells``, the likeliest first.

    A soak is judged by face, heading and stillness alone: what its counts drift by is what it is for.
    """

    def __init__(self, context: StageContext, face: str, dwells: Sequence[FaceStep], again: NextStage) -> None:
        super().__init__(context, dwells[0], again)
        self._face, self._dwells = face, dwells
        self._seat = SeatCheck(context, face)
        self._is_neither = False
        self._position, self._how = context.position, AS_ANSWERED if context.position else ""
        if not dwells[0].position:  # a soak that wants the face only
            self._how = ANY_HEADING

    @property
    def _step(self) -> FaceStep:
        """The dwell that this is, as far as it is known."""
        return next((each for each in self._dwells if each.position == self._position), self._dwells[0])

    def take(self, block: Block, look: BlockLook) -> Stage:
        if self._is_neither:
            return self._again("set the cube down along the marks on the surface plate", must_move=True)
        if restarted := self._restarted(block, look):
            return restarted
        if self._dwelling.is_disturbed or not self._dwelling.kept:
            return self
        why = self._wrong_heading()
        if not why and not self._is_soak:
            why = self._seat.fault(self._dwelling, self._position)
        if why:
            return self._again(why, must_move=True)
        if self._is_long_enough():
            self._dwelling.stop_early()
        return self._completed() if self._dwelling.is_complete else self

    def interrupted(self) -> Stage:
        self._context.position = 0
        return self._again("the data stream was interrupted; the dwell starts again", must_move=False)

    def answer(self, key: str) -> None:
        self._is_neither = key == NEITHER
        if key in {choice.key for choice in self._choices.choices} - {NEITHER}:
            self._position, self._how = int(key), AS_ANSWERED

    def shown(self) -> dict[str, Any]:
        step = self._step
        shown = self._progress(step, step_title(step) if self.is_known else f"{step_title(step)}?")
        if self._question and self._dwelling.is_complete:
            shown["hint"] = "recorded; it is accepted when the heading of the cube is known"
        gates = {
            "position": self._position, "heading": self._how or "measuring the Earth rate",
            "seating": self._seat.words, "is_seated": not self._seat.is_to_lift,
        }  # fmt: skip
        return shown | {"question": self._question, "gates": gates}

    @property
    def _is_along_marks(self) -> bool:
        return self._how != ANY_HEADING

    @property
    def is_known(self) -> bool:
        """Whether it is known which way the cube points, as far as that matters."""
        return bool(self._position) or self._how == ANY_HEADING

    @property
    def _question(self) -> OperatorQuestion | None:
        if self.is_known or not self._context.bench.asks:
            return None
        is_time = self._dwelling.accepted_s >= ASK_AFTER_S or self._dwelling.is_complete
        return self._choices if is_time else None

    @property
    def _choices(self) -> OperatorQuestion:
        return which_position(self._face, (each.position for each in self._dwells if each.position))

    def _wrong_heading(self) -> str:
        """Read the heading; say what is wrong with it."""
        if self._how in {BY_EARTH, ANY_HEADING}:
            return ""
        context, seconds = self._context, self._dwelling.accepted_s
        found = context.heading(self._dwelling.rate()[:3], seconds, self._face)
        if not found.is_sure:
            return ""
        stands, wanted = turned_position(self._face, found.quarter), self._dwells[0].position
        if found.position is None and all(each.position != stands for each in self._dwells):
            turn = QUARTERS[quarters_to(wanted, found.quarter)]
            return f"the heading is wrong: turn {turn} from above, to position {position_name(wanted)}"
        self._position, self._how = stands, BY_EARTH
        return self._nothing_left()

    def _nothing_left(self) -> str:
        """Say so if there is nothing to do in this position."""
        if any(each.position == self._position for each in self._dwells):
            return ""
        is_done = self._context.checklist.dwell_at(self._position) is not None
        why = f"position {position_name(self._position)} is {'done already' if is_done else 'not requested'}"
        wanted, quarters = self._dwells[0].position, range(4)
        stands = next(q for q in quarters if turned_position(self._face, q) == self._position)
        turn = {1: "90 deg, counter-clockwise", 3: "90 deg, clockwise"}.get(quarters_to(wanted, stands), "180 deg")
        return f"{why}; position {position_name(wanted)} is the same face turned by {turn}"

    def _is_long_enough(self) -> bool:
        """Say whether more of this dwell would not pay: with it all is met that is wanted."""
        seconds = self._dwelling.accepted_s
        return self.is_known and seconds >= SHORTEST_S and self._context.is_enough(self._step, seconds)

    def _result(self) -> dict[str, object]:
        """Return further values for its table in ``campaign.toml``."""
        return {}

    @property
    def _up(self) -> FloatArray:
        return face_normal(self._face)

    def _accepted(self) -> Stage:
        context, dwelling = self._context, self._dwelling
        if not self.is_known and not context.bench.asks:
            self._position, self._how = self._dwells[0].position, AS_ASKED
        if not self.is_known:
            return self
        if why := "" if self._is_soak else self._seat.judged(dwelling.runs(), self._position):
            return self._again(why, must_move=True)
        if why := "" if self._how == ANY_HEADING else self._nothing_left():
            return self._again(why, must_move=True)
        kept, step, runs = None if self._is_soak else self._seat.kept, self._step, dwelling.runs()
        seats = recheck_seats(context, step, runs, self._seat) if isinstance(step, Dwell) else {}
        context.accept(step, runs, kept_seat=kept, read=self._result(), seats=seats)
        repeat_marked(context, step, seats)
        reject_tilted_turns(context)
        return after_dwell(context, lambda why: self._again(why, must_move=True))


def free_look(context: StageContext, block: Block, look: BlockLook) -> BlockLook:
    """Return ``look`` with the gate of a free attitude in the place of the face's."""
    up = context.gate.way_up(block.rate[3:])
    apart = nearest_deg(up, context.tilts_taken())
    fault = ""
    if look.off_deg < MIN_APART_DEG:
        fault = f"{look.off_deg:.0f} deg from the nearest face, at least {MIN_APART_DEG:.0f}: tilt it further"
    elif apart < MIN_APART_DEG:
        limit = f"at least {MIN_APART_DEG:.0f}: tilt it in another direction"
        fault = f"{apart:.0f} deg from an attitude already recorded, {limit}"
    hindrance = look.hindrance if not look.is_still else fault
    return replace(look, is_upright=not fault, hindrance=hindrance)


class FreeAttitudeStage(RestRecording):
    """One attempt at a free position, or at a soak in a free attitude."""

    def __init__(self, context: StageContext, step: FreePosition | Soak, again: NextStage) -> None:
        super().__init__(context, step, again)
        self._step = step

    def take(self, block: Block, look: BlockLook) -> Stage:
        if restarted := self._restarted(block, free_look(self._context, block, look)):
            return restarted
        return self._completed() if self._dwelling.is_complete and not self._dwelling.is_disturbed else self

    def interrupted(self) -> Stage:
        return self._again("the data stream was interrupted; the recording starts again", must_move=False)

    def shown(self) -> dict[str, Any]:
        return self._progress(self._step, step_title(self._step)) | {"gates": {"is_free": True}}

    @property
    def _up(self) -> FloatArray:
        return self._context.gate.way_up(self._dwelling.rate()[3:])

    def _accepted(self) -> Stage:
        self._context.free_attitudes[self._step.name] = np.array(self._dwelling.rate()[3:])
        self._context.accept(self._step, self._dwelling.runs())
        return self._again("", must_move=True)

"""A rest in a free attitude under way: leaning between faces, unlike those taken, as still as any dwell.

What its attitude is nobody asks: the accelerometers say it well enough to tell it from the others.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from procedures.campaign.plan_steps import FreePosition, Soak
from procedures.rests_and_moves.free_attitudes import MIN_APART_DEG, nearest_deg
from station.guide.accepted_dwell import triad_estimates
from station.guide.dwell_attempt import TOUCHED, DwellAttempt, crept
from station.guide.dwell_stage import NextStage
from station.guide.face_and_stillness import BlockLook
from station.guide.instruction_words import step_title
from station.guide.soak_progress import SoakTemperature, soak_in_words
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.stream.live.accepted_blocks import series_of_runs
from station.stream.live.stillness import Block


def free_look(context: StageContext, block: Block, look: BlockLook) -> BlockLook:
    """Return ``look`` with the gate of a free attitude in the place of the face's."""
    up = context.gate.way_up(block.rate[3:])
    apart = nearest_deg(up, context.leans_taken())
    fault = ""
    if look.off_deg < MIN_APART_DEG:
        fault = f"{look.off_deg:.0f} deg from the nearest face, at least {MIN_APART_DEG:.0f}: lean it further"
    elif apart < MIN_APART_DEG:
        fault = (
            f"{apart:.0f} deg from an attitude taken already, at least {MIN_APART_DEG:.0f}: lean it another way"
        )
    hindrance = look.hindrance if not look.is_still else fault
    return replace(look, is_upright=not fault, hindrance=hindrance)


class FreeAttitudeStage:
    """One attempt at a free position, or at a soak in a free attitude."""

    def __init__(self, context: StageContext, step: FreePosition | Soak, again: NextStage) -> None:
        self._context, self._step, self._again = context, step, again
        period = context.feed.period
        self._is_soak = isinstance(step, Soak)
        samples = round(step.seconds / period)
        self._dwelling = DwellAttempt(samples, period, context.rough_gyro_k, drifts=self._is_soak)
        self._thermometer = SoakTemperature()
        context.event_log.say("start", "recording: keep your hands off")

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return self._dwelling.oldest

    def take(self, block: Block, look: BlockLook) -> Stage:
        """Take a second of the stream."""
        context, dwelling = self._context, self._dwelling
        was_disturbed = dwelling.is_disturbed
        self._thermometer.take(block)
        if why := dwelling.take(block, free_look(context, block, look)):
            if why == TOUCHED:
                context.event_log.say("still", "not let go yet: keep your hands off")
                return self._again(context, "", must_move=False)
            return self._again(context, f"{why}; it begins again", must_move=False)
        if dwelling.is_disturbed and not was_disturbed:
            context.event_log.say("still", "disturbed: keep still, only those seconds are left out")
        return self._completed() if dwelling.is_complete and not dwelling.is_disturbed else self

    def interrupted(self) -> Stage:
        """Give it up: the stream broke it."""
        return self._again(self._context, "the stream was interrupted; it begins again", must_move=False)

    def answer(self, key: str) -> None:
        """Nothing is asked."""

    def shown(self) -> dict[str, Any]:
        """Return how far it is."""
        dwelling, wanted_s = self._dwelling, self._step.seconds
        accepted_s = min(dwelling.accepted_s, wanted_s)
        line = f"{step_title(self._step)}: {accepted_s:.0f} of {wanted_s:.0f} s, hands off"
        soak = self._thermometer.view(wanted_s - accepted_s) if self._is_soak else None
        return {
            "stage": "dwell", "live": self._step.name, "accepted_s": accepted_s, "wanted_s": wanted_s,
            "hint": "disturbed: those seconds are left out; keep still" if dwelling.is_disturbed else "",
            "line": f"{line}; {soak_in_words(soak)}" if soak else line, "soak": soak, "is_free": True,
        }  # fmt: skip

    def _completed(self) -> Stage:
        context, dwelling = self._context, self._dwelling
        dwelling.forget_restless(context.gate.stillness.is_still)
        if not dwelling.is_complete:
            return self
        if not self._is_soak:
            recorded = series_of_runs(context.feed.buffer, dwelling.runs(), context.feed.period)
            up = context.C_sb @ context.gate.way_up(dwelling.rate()[3:])
            if why := crept(triad_estimates(recorded.accel, recorded), dwelling.accepted_s, up):
                return self._again(context, f"{why}; it begins again", must_move=False)
        context.free_attitudes[self._step.name] = np.array(dwelling.rate()[3:])
        context.accept(self._step, dwelling.runs())
        return self._again(context, "", must_move=True)

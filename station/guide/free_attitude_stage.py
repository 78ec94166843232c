"""A rest in a free attitude under way: leaning between faces, unlike those taken, as still as any dwell.

What its attitude is nobody asks: the accelerometers say it well enough to tell it from the others.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from procedures.campaign.plan_steps import FreePosition, Soak
from procedures.free_positions.free_attitudes import MIN_APART_DEG, nearest_deg
from station.guide.dwell_stage import NextStage, RestRecording
from station.guide.face_and_stillness import BlockLook
from station.guide.instruction_words import step_title
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.stream.live.stillness import Block


def free_look(context: StageContext, block: Block, look: BlockLook) -> BlockLook:
    """Return ``look`` with the gate of a free attitude in the place of the face's."""
    up = context.gate.way_up(block.rate[3:])
    apart = nearest_deg(up, context.leans_taken())
    fault = ""
    if look.off_deg < MIN_APART_DEG:
        fault = f"{look.off_deg:.0f} deg from the nearest face, at least {MIN_APART_DEG:.0f}: tilt it further"
    elif apart < MIN_APART_DEG:
        fault = (
            f"{apart:.0f} deg from an attitude already recorded, at least {MIN_APART_DEG:.0f}: tilt it in another "
            "direction"
        )
    hindrance = look.hindrance if not look.is_still else fault
    return replace(look, is_upright=not fault, hindrance=hindrance)


class FreeAttitudeStage(RestRecording):
    """One attempt at a free position, or at a soak in a free attitude."""

    def __init__(self, context: StageContext, step: FreePosition | Soak, again: NextStage) -> None:
        super().__init__(context, step, again)
        self._step = step

    def take(self, block: Block, look: BlockLook) -> Stage:
        """Take a second of the stream."""
        if begun_again := self._begun_again(block, free_look(self._context, block, look)):
            return begun_again
        return self._completed() if self._dwelling.is_complete and not self._dwelling.is_disturbed else self

    def interrupted(self) -> Stage:
        """Give it up: the stream broke it."""
        return self._again("the data stream was interrupted; the recording starts again", must_move=False)

    def shown(self) -> dict[str, Any]:
        """Return how far it is."""
        return self._progress(self._step, step_title(self._step)) | {"is_free": True}

    def _completed(self) -> Stage:
        context, dwelling = self._context, self._dwelling
        dwelling.forget_restless(context.gate.stillness.is_still)
        if not dwelling.is_complete:
            return self
        if why := self._crept(context.C_sb @ context.gate.way_up(dwelling.rate()[3:])):
            return self._again(f"{why}; the recording starts again", must_move=False)
        context.free_attitudes[self._step.name] = np.array(dwelling.rate()[3:])
        context.accept(self._step, dwelling.runs())
        return self._again("", must_move=True)

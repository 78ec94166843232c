"""Placement: wait until the cube rests on a face where a step is open. Any order is accepted.

There is one instruction at a time: place the cube; then hands off, until it is lifted, tipped or rotated.
"""

from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell, Monitor, Soak, Turn
from procedures.free_positions.free_attitudes import MIN_APART_DEG, next_direction
from procedures.positions import face_of
from station.guide.campaign.checklist import is_free
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.stages.dwell_stage import DwellStage, FreeAttitudeStage, free_look
from station.guide.stages.monitor_stage import MonitorStage
from station.guide.stages.stage import Stage
from station.guide.stages.stage_context import StageContext
from station.guide.stages.turn_stage import TurnStage
from station.guide.wording import face_in_words, instruction, rest_before, step_title
from station.stream.live.stillness import Block

SETTLE_BLOCKS = 3  # still ones that are not used
TURNED_AWAY_DEG = 10.0  # a cube that rocks or is bumped turns by far less, one that a hand turns by 90 deg
HANDS_OFF = "hands off: wait until the cube is at rest"
LEARNING = "wait, hands off: the noise of the unit at rest is being measured"
SET_DOWN_AGAIN = "lift the cube, wipe it and the plate, set it down as before"


class PlacementStage(Stage):
    """The cube is to be moved: after an accepted step it must be seen to move before another can begin.

    ``why`` says what was wrong with how it stood, empty if nothing was.
    """

    def __init__(self, context: StageContext, *, must_move: bool, why: str = "") -> None:
        super().__init__(context)
        self._must_move, self._why = must_move, why
        self._face, self._calm, self._hint = "", 0, ""
        self._is_free = False
        self._rest: FloatArray | None = None  # (3,) count/s, the gyros as the cube came to rest
        self._turned = np.zeros(3)  # counts since then
        look = context.look
        self._is_placed = look is not None and self._stands(look)

    def take(self, block: Block, look: BlockLook) -> Stage:
        judge = self._context.gate
        if self._context.checklist.wanted is None:
            return self
        if judge.stillness.is_known and not look.is_still:
            self._must_move = False
            self._context.moved()
        self._is_free = self._wants_free(look)
        look = free_look(self._context, block, look) if self._is_free else look
        if self._must_move and not self._begins_here(look):
            self._is_placed = False
            return self
        is_calm = not look.hindrance and look.is_calm and (self._is_free or look.face == self._face)
        self._calm = self._calm + 1 if is_calm else 0
        self._is_placed = self._stays(block, look) if self._is_placed else is_calm and self._has_work(look)
        if is_calm:
            self._rest, self._turned = block.rate[:3], np.zeros(3)
        self._face, self._hint = look.face, look.hindrance
        if self._calm < SETTLE_BLOCKS:
            return self
        step = self._context.checklist.open_free() if self._is_free else None
        return FreeAttitudeStage(self._context, step, self._again) if step else self._arrived(look.face)

    def interrupted(self) -> Stage:
        """Wait again; the cube may have been moved meanwhile."""
        return PlacementStage(self._context, must_move=False, why=self._why)

    def shown(self) -> dict[str, Any]:
        step, is_known = self._context.checklist.wanted, self._context.gate.stillness.is_known
        tilt = next_direction(self._context.tilts_taken()) if step is not None and is_free(step) else None
        what = instruction(step, way=tilt or (1, 1, 0)) if step else "all steps are done"
        hint = self._why or (self._hint if not self._must_move else "")
        shown: dict[str, Any] = {"stage": "place", "line": what, "hint": hint}
        shown |= {"tilt": tilt, "gates": {"is_free": self._is_free}}
        if step and not is_known:
            shown |= {"stage": "settle", "line": LEARNING, "hint": self._why}
        elif self._is_placed:
            shown |= {"stage": "settle", "line": HANDS_OFF}
            if isinstance(step, Turn) and self._face == face_of(step.start_position):
                shown["line"] = rest_before(step)
        if self._context.off_seat:  # one thing at a time: not where it is to go next
            why = self._why.removesuffix("; lift, wipe, set down")  # which stands above it
            shown |= {"line": SET_DOWN_AGAIN, "hint": why, "gates": {"is_seated": False, "seating": why}}
        return shown

    def _stands(self, look: BlockLook) -> bool:
        """Say whether the cube is where something is to do, and need not be moved for it."""
        if self._must_move and not self._begins_here(look):
            return False
        self._face = look.face
        is_free = self._wants_free(look)
        return (is_free and look.off_deg >= MIN_APART_DEG) or (look.is_upright and self._has_work(look))

    def _has_work(self, look: BlockLook) -> bool:
        """Say whether something is to do as the cube rests now."""
        return self._is_free or self._context.checklist.has_work(look.face)

    def _stays(self, block: Block, look: BlockLook) -> bool:
        """Say whether the cube is still where it was put: neither lifted nor tipped nor turned away."""
        if not look.is_upright or (look.face != self._face and not self._is_free):
            return False
        if self._rest is None or look.is_still:
            return True
        self._turned += (block.rate[:3] - self._rest) * (block.last - block.first) * self._context.feed.period
        k = self._context.rough_gyro_k(self._rest)
        return bool(np.linalg.norm(self._turned) <= np.radians(TURNED_AWAY_DEG) * k)

    def _begins_here(self, look: BlockLook) -> bool:
        """Say whether the wanted step begins where the cube stands, so that it need not be moved."""
        step, position = self._context.checklist.wanted, self._context.position
        if look.hindrance or self._why:
            return False
        if self._is_free or not position:  # tilted as requested: accepted without another placement
            return self._is_free
        was_dwell = self._context.checklist.latest in self._context.accepted_dwells
        if isinstance(step, Dwell) and step.repeat and was_dwell:
            return False  # a seating of its own
        if isinstance(step, Soak):
            return look.face == step.face and step.position in {0, position}
        return (step.start_position if isinstance(step, Turn) else getattr(step, "position", 0)) == position

    def _wants_free(self, look: BlockLook) -> bool:
        """Say whether the cube is to be judged by the gate of a free attitude as it is tilted now."""
        checklist = self._context.checklist
        if checklist.open_free() is None:
            return False
        if look.off_deg >= MIN_APART_DEG:
            return True
        step = checklist.wanted
        has_work = checklist.open_dwells(look.face) or checklist.open_soak(look.face)
        return step is not None and is_free(step) and not (look.is_upright and has_work)

    def _arrived(self, face: str) -> Stage:
        context = self._context
        step, soak = context.checklist.wanted, context.checklist.open_soak(face)
        if isinstance(step, Turn) and face_of(step.start_position) == face:
            return TurnStage(context, step, self._again)
        dwells = context.checklist.open_dwells(face)
        if isinstance(soak, Monitor) and (soak == step or not dwells):
            return MonitorStage(context, soak, self._again)
        if soak and (soak == step or not dwells):
            return DwellStage(context, face, [soak], self._again)
        return DwellStage(context, face, dwells, self._again) if dwells else self._wrong(face)

    def _again(self, why: str, *, must_move: bool) -> Stage:
        if why:
            self._context.event_log.say("rejected", why)
        return PlacementStage(self._context, must_move=must_move, why=why if must_move else "")

    def _wrong(self, face: str) -> Stage:
        left = "nothing remains to be done there"
        for step in self._context.checklist.open_steps:
            if isinstance(step, Turn) and face_of(step.start_position) == face:
                left = f"its positions are done; {step_title(step)} follows later, or choose it now"
                break
        return self._again(f"{face_in_words(face)}: {left}", must_move=True)

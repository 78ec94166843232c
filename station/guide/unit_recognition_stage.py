"""Is this the unit that the campaign began with? Asked where the wire does not say a serial number."""

from collections.abc import Callable
from typing import Any

import numpy as np

from station.files.campaign_folder.plan_file import UnitRecord
from station.guide.face_and_stillness import BlockLook
from station.guide.setup_view import Choice
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.guide.unit_identity import same_unit
from station.guide.view import OperatorQuestion
from station.stream.connected_unit import UnitChanged
from station.stream.live.stillness import Block

RECOGNITION_BLOCKS = 10


class UnitRecognitionStage(Stage):
    """Compares ten seconds at rest with the campaign's first dwell, then asks."""

    def __init__(self, context: StageContext, before: UnitRecord, then: Callable[[StageContext], Stage]) -> None:
        super().__init__(context)
        self._before, self._then = before, then
        self._blocks: list[Block] = []
        self._text, self._answer, self._hint = "", "", ""

    def take(self, block: Block, look: BlockLook) -> Stage:
        """Take a second of the stream."""
        self._hint = look.hindrance
        if self._answer == "y":
            return self._then(self._context)
        if self._text:
            return self
        self._blocks = [] if look.hindrance else [*self._blocks, block]
        if len(self._blocks) == RECOGNITION_BLOCKS:
            self._compare()
        return self

    def answer(self, key: str) -> None:
        """Take the operator's word; raise `UnitChanged` if it is another unit."""
        if key == "n":
            raise UnitChanged(self._context.feed.address.name, "another unit", self._before.serial)
        self._answer = key

    def interrupted(self) -> Stage:
        """Look again."""
        return UnitRecognitionStage(self._context, self._before, self._then)

    def shown(self) -> dict[str, Any]:
        """Return the question, once there is something to say."""
        line = f"is this {self._before.model} {self._before.serial}?"
        shown = {"stage": "settle", "line": line, "hint": self._hint or "leave the cube at rest"}
        choices = (Choice(key="y", title="yes, it is"), Choice(key="n", title="no, it is another"))
        question = OperatorQuestion(text=f"{line} {self._text}", choices=choices) if self._text else None
        return shown | {"question": question}

    def _compare(self) -> None:
        rate = np.mean([block.rate for block in self._blocks], axis=0)
        seen = {"rate": tuple(rate.tolist()), "noise": tuple(self._context.gate.stillness.noise.tolist())}
        found = same_unit(self._before, self._before.model_copy(update={**seen, "serial_from_wire": False}))
        if not self._context.bench.asks:
            if found.answer != "yes":
                raise UnitChanged(
                    self._context.feed.address.name, f"a unit that {found.text}", self._before.serial
                )
            self._answer = "y"
        self._text = f"It sends no serial number; {found.text}."

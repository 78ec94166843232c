"""A question that only the operator can answer; the cube stands meanwhile, and what is done next hangs on it."""

from collections.abc import Callable, Mapping
from typing import Any

from station.guide.face_and_stillness import BlockLook
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.guide.view import OperatorQuestion
from station.stream.live.stillness import Block


class QuestionStage:
    """Asks ``question``; ``then`` says by the answer's key which stage goes on."""

    oldest: int | None = None

    def __init__(
        self, context: StageContext, question: OperatorQuestion, then: Mapping[str, Callable[[], Stage]]
    ) -> None:
        self._context, self._question, self._then = context, question, then
        self._answer = ""

    def take(self, block: Block, look: BlockLook) -> Stage:
        """Take a second of the stream."""
        if look.hindrance and not look.is_still:
            self._context.moved()
        return self._then[self._answer]() if self._answer else self

    def answer(self, key: str) -> None:
        """Take the operator's word."""
        self._answer = key if key in self._then else ""

    def interrupted(self) -> Stage:
        """Ask on: no sample hangs on it."""
        self._context.moved()
        return self

    def shown(self) -> dict[str, Any]:
        """Return the question."""
        return {"stage": "settle", "line": self._question.text, "question": self._question}

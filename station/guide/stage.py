"""A stage of a guided campaign: it is given each second of the stream and says which stage comes next."""

from typing import Any

from station.guide.face_and_stillness import BlockLook
from station.guide.stage_context import StageContext
from station.stream.live.stillness import Block


class Stage:
    """One thing being done: placing, resting, turning, warming up."""

    def __init__(self, context: StageContext) -> None:
        self._context = context

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return None

    def take(self, block: Block, look: BlockLook) -> "Stage":
        """Take a second of the stream; return the stage that goes on, itself or the next."""
        raise NotImplementedError

    def interrupted(self) -> "Stage":
        """Return the stage that goes on when the stream has begun anew: nothing before counts any more."""
        raise NotImplementedError

    def answer(self, key: str) -> None:
        """Take the operator's word; most ask nothing."""

    def shown(self) -> dict[str, Any]:
        """Return the fields of `station.guide.view.CalibrationView` that this stage sets."""
        raise NotImplementedError

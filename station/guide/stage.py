"""A stage of a guided campaign: it is given each second of the stream and says which stage comes next."""

from typing import Any, Protocol

from station.guide.face_and_stillness import BlockLook
from station.stream.live.stillness import Block


class Stage(Protocol):
    """One thing being done: placing, resting, turning, warming up."""

    def take(self, block: Block, look: BlockLook) -> "Stage":
        """Take a second of the stream; return the stage that goes on, itself or the next."""
        ...

    def interrupted(self) -> "Stage":
        """Return the stage that goes on when the stream has begun anew: nothing before counts any more."""
        ...

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        ...

    def shown(self) -> dict[str, Any]:
        """Return the fields of `station.guide.view.CalibrationView` that this stage sets."""
        ...

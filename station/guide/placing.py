"""Wait until the cube rests on a face that has something to do; any order is taken, and nobody is hurried."""

from typing import Any

from procedures.frames import face_of
from procedures.steps import Turn
from station.guide.desk import Desk
from station.guide.judge import Look
from station.guide.resting import Resting
from station.guide.stage import Stage
from station.guide.turning import Turning
from station.guide.wording import face as face_words
from station.guide.wording import task, title
from station.live.stillness import Block

SETTLE_BLOCKS = 3  # still ones that are not used


class Placing:
    """The cube is to be moved: after an accepted step it must be seen to move before another can begin.

    ``why`` says what was wrong with how it stood, empty if nothing was.
    """

    oldest: int | None = None

    def __init__(self, desk: Desk, *, must_move: bool, why: str = "") -> None:
        self._desk, self._must_move = desk, must_move
        self._why = why
        self._face, self._calm, self._hint = "", 0, ""

    def take(self, block: Block, look: Look) -> Stage:
        """Take a second of the stream."""
        judge = self._desk.judge
        if self._desk.checklist.wanted is None:
            return self
        if judge.stillness.is_known and not look.is_still:
            self._must_move = False
            self._desk.moved()
        if self._must_move and not self._begins_here(look):
            return self
        is_calm = not look.hindrance and look.is_calm and look.face == self._face
        self._calm = self._calm + 1 if is_calm else 0
        self._face, self._hint = look.face, look.hindrance
        if self._calm < SETTLE_BLOCKS:
            return self
        return self._arrived(look.face)

    def interrupted(self) -> Stage:
        """Wait anew; the cube may have been moved meanwhile."""
        return Placing(self._desk, must_move=False, why=self._why)

    def shown(self) -> dict[str, Any]:
        """Return where the cube is to go, and what hinders."""
        wanted, position = self._desk.checklist.wanted, self._desk.position
        is_there = isinstance(wanted, Turn) and wanted.start_position == position
        what = task(wanted, is_there=is_there) if wanted else "all steps are done"
        hint = self._why or (self._hint if not self._must_move else "")
        shown = {"stage": "settle" if self._calm else "place", "line": what, "hint": hint}
        return shown | ({"is_seated": False, "seating": self._why} if self._desk.off_seat else {})

    def _begins_here(self, look: Look) -> bool:
        """Say whether the wanted step begins where the cube stands, so that it need not be moved."""
        wanted, position = self._desk.checklist.wanted, self._desk.position
        if look.hindrance or not position or self._why:
            return False
        return (wanted.start_position if isinstance(wanted, Turn) else getattr(wanted, "position", 0)) == position

    def _arrived(self, face: str) -> Stage:
        desk = self._desk
        wanted = desk.checklist.wanted
        if isinstance(wanted, Turn) and face_of(wanted.start_position) == face:
            return Turning(desk, wanted, _again)
        if dwells := desk.checklist.open_dwells(face):
            return Resting(desk, face, dwells, _again)
        return self._wrong(face)

    def _wrong(self, face: str) -> Stage:
        turns = [each for each in desk_turns(self._desk) if face_of(each.start_position) == face]
        left = f"{title(turns[0])} comes later, or choose it" if turns else "nothing is left to do there"
        why = f"{face_words(face)}: {'its positions are done; ' if turns else ''}{left}"
        self._desk.story.say("rejected", why)
        return Placing(self._desk, must_move=True, why=why)


def desk_turns(desk: Desk) -> list[Turn]:
    """Return the turns that are to be done."""
    checklist = desk.checklist
    return [step for step in checklist.steps if isinstance(step, Turn) and checklist.is_open(step)]


def _again(desk: Desk, why: str, *, must_move: bool) -> Stage:
    if why:
        desk.story.say("rejected", why)
    return Placing(desk, must_move=must_move, why=why if must_move else "")

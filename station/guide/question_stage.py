"""What the operator alone can answer, and the stage that waits for an answer; the cube stands meanwhile."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from procedures.campaign.plan_steps import Turn
from procedures.frames import POSITIONS, face_of, position_name
from station.guide.face_and_stillness import BlockLook
from station.guide.instruction_words import axes_in_words, step_title, turn_sense
from station.guide.setup_view import Choice
from station.guide.stage import Stage
from station.guide.stage_context import StageContext
from station.guide.view import OperatorQuestion
from station.stream.live.stillness import Block

NEITHER = "n"
TAKE = "y"
OTHER_WAY = (TAKE, "n")


class QuestionStage(Stage):
    """Asks ``question``; ``then`` says by the answer's key which stage goes on."""

    def __init__(
        self, context: StageContext, question: OperatorQuestion, then: Mapping[str, Callable[[], Stage]]
    ) -> None:
        super().__init__(context)
        self._question, self._then = question, then
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


def which_position(face: str, asked: Iterable[int] = ()) -> OperatorQuestion:
    """Ask which of a face's two positions it is, or of those ``asked`` for; the answer's key is the position."""
    pair = [p for p in range(1, len(POSITIONS) + 1) if face_of(p) == face]
    may_be = list(dict.fromkeys([*pair, *asked]))
    choices = [Choice(key=str(p), title=f"position {position_name(p)}: {axes_in_words(p)}") for p in may_be]
    none = "neither" if len(may_be) == len(pair) else "none of them"
    choices.append(Choice(key=NEITHER, title=f"{none}: I place it again"))
    text = "The Earth rate does not determine the heading of the cube. Which position is it?"
    return OperatorQuestion(text=text, choices=tuple(choices))


def which_turn(asked: Turn, other: Turn) -> OperatorQuestion:
    """Ask whether a turn the wrong way is to be the other step, which is to be done as well."""
    text = f"You turn {turn_sense(other)}: that is {step_title(other)}; requested is {step_title(asked)}."
    choices = (
        Choice(key=TAKE, title=f"record it as {step_title(other)}: continue to the end"),
        Choice(key=OTHER_WAY[1], title=f"no: I start {step_title(asked)} again, {turn_sense(asked)}"),
    )
    return OperatorQuestion(text=text, choices=choices)

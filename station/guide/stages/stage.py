"""A stage of a guided campaign takes each second of the stream and returns the stage that comes next.

Here are the base of all stages and the one that waits for an answer, with the questions that only the operator can
answer. A wrong heading shows only after other faces have shown the gyroscopes' biases.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, Protocol

from procedures.bench.position_checks import HeadingError, heading_error_text
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.positions import POSITIONS, face_of, position_name
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.setup_view import Choice
from station.guide.stages.stage_context import StageContext
from station.guide.view import OperatorQuestion
from station.guide.wording import axes_in_words, step_title, turn_sense
from station.stream.live.stillness import Block


class Stage:
    """One thing being done: placement, resting, turning, warming up."""

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
        """Return the stage that continues after the stream has restarted: nothing before it counts."""
        raise NotImplementedError

    def answer(self, key: str) -> None:
        """Take the operator's word; most ask nothing."""

    def shown(self) -> dict[str, Any]:
        """Return the fields of `station.guide.view.CalibrationView` that this stage sets."""
        raise NotImplementedError


NEITHER = "n"
TAKE = "y"
OTHER_WAY = (TAKE, "n")


class NextStage(Protocol):
    """Makes the stage that comes after this one; ``why`` is reported, empty if all is well."""

    def __call__(self, why: str, *, must_move: bool) -> Stage:
        """Return the stage."""


class QuestionStage(Stage):
    """Asks ``question``; ``then`` says by the answer's key which stage goes on."""

    def __init__(
        self, context: StageContext, question: OperatorQuestion, then: Mapping[str, Callable[[], Stage]]
    ) -> None:
        super().__init__(context)
        self._question, self._then = question, then
        self._answer = ""

    def take(self, block: Block, look: BlockLook) -> Stage:
        if look.hindrance and not look.is_still:
            self._context.moved()
        return self._then[self._answer]() if self._answer else self

    def answer(self, key: str) -> None:
        self._answer = key if key in self._then else ""

    def interrupted(self) -> Stage:
        """Keep asking: the answer does not depend on samples."""
        self._context.moved()
        return self

    def shown(self) -> dict[str, Any]:
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


REDO, KEEP = "r", "k"


def after_dwell(context: StageContext, again: Callable[[str], Stage]) -> Stage:
    """Return the stage after an accepted dwell; ``again`` makes the usual one from the reason to move the cube."""
    for dwells, error in context.wrong_headings():
        names = {dwell.name: dwell for dwell in sorted(dwells, key=lambda each: (each.position, each.repeat))}
        dwell = names.get(context.checklist.latest, dwells[0])  # where it may be several
        if (key := tuple(names)) in context.reported_turned or context.checklist.step(dwell.name) is None:
            continue
        context.reported_turned.add(key)
        text = f"position {' or '.join(each.words for each in names.values())} {heading_error_text(error)}"
        context.event_log.say("rejected", text)
        if not context.bench.asks:  # once: the second time it stands as it is, and the solution says so
            return (
                _redo(context, dwell, error, again) if context.checklist.attempts[dwell.name] == 1 else again("")
            )
        then = {REDO: partial(_redo, context, dwell, error, again), KEEP: partial(again, "")}
        choices = (
            Choice(key=REDO, title=f"record position {dwell.words} again, set along the marks"),
            Choice(key=KEEP, title="keep it: the solution lists it, the uncertainties do not include it"),
        )
        return QuestionStage(
            context, OperatorQuestion(text=f"{text[0].upper()}{text[1:]}.", choices=choices), then
        )
    return again("")


def _redo(context: StageContext, dwell: Dwell, error: HeadingError, again: Callable[[str], Stage]) -> Stage:
    context.checklist.redo(dwell.name)
    way = "counter-clockwise" if error.angle > 0 else "clockwise"
    return again(f"set position {dwell.words} along the marks: it was too far {way}")

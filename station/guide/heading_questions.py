"""What the operator alone can answer: which way the cube points, and which turn one the wrong way was to be."""

from procedures.campaign.plan_steps import Turn
from procedures.frames import POSITIONS, face_of
from station.guide.instruction_words import axes_in_words, step_title, turn_sense
from station.guide.setup_view import Choice
from station.guide.view import OperatorQuestion

NEITHER = "n"
TAKE = "y"
OTHER_WAY = (TAKE, "n")


def which_position(face: str) -> OperatorQuestion:
    """Ask which of the two positions of a face it is; the answer's key is the position."""
    pair = [p for p in range(1, len(POSITIONS) + 1) if face_of(p) == face]
    choices = [Choice(key=str(p), title=f"position {p}: {axes_in_words(p)}") for p in pair]
    choices.append(Choice(key=NEITHER, title="neither: I set it down again"))
    text = "The Earth rate does not tell which way the cube points. Which is it?"
    return OperatorQuestion(text=text, choices=tuple(choices))


def which_turn(asked: Turn, other: Turn) -> OperatorQuestion:
    """Ask whether a turn the wrong way is to be the other step, which is to be done as well."""
    text = f"You turn {turn_sense(other)}: that is {step_title(other)}, asked for is {step_title(asked)}."
    choices = (
        Choice(key=TAKE, title=f"take it as {step_title(other)}: turn on to the end"),
        Choice(key=OTHER_WAY[1], title=f"no: I begin {step_title(asked)} anew, {turn_sense(asked)}"),
    )
    return OperatorQuestion(text=text, choices=choices)

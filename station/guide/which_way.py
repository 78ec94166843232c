"""The question that the operator alone can answer where the Earth rate does not: which way the cube points."""

from procedures.frames import POSITIONS, face_of
from station.guide.view import Choice, Question
from station.guide.wording import axes

NEITHER = "n"


def which_way(face: str) -> Question:
    """Ask which of the two positions of a face it is; the answer's key is the position."""
    pair = [p for p in range(1, len(POSITIONS) + 1) if face_of(p) == face]
    choices = [Choice(key=str(p), title=f"position {p}: {axes(p)}") for p in pair]
    choices.append(Choice(key=NEITHER, title="neither: I set it down again"))
    text = "The Earth rate does not tell which way the cube points. Which is it?"
    return Question(text=text, choices=tuple(choices))

"""What a bench says while it works, for a screen or a line of text."""

from dataclasses import dataclass
from typing import Literal

from procedures.steps import Step

Phase = Literal["place", "settle", "dwell", "turn", "accepted", "redo"]


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a step stands.

    ``seconds`` of ``wanted`` are device time: of accepted samples in a dwell, since the cube began to move in a
    turn. ``note`` says in words what hinders, such as the wrong face; empty if nothing does.
    """

    step: Step
    phase: Phase
    seconds: float = 0.0
    wanted: float = 0.0
    note: str = ""

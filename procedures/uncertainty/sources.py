"""The sources of uncertainty by name, and the estimates that their sizes rest on."""

from collections.abc import Mapping
from dataclasses import dataclass

from procedures.arrays import FloatArray

COUNTING = "counting noise"
QUANTISATION = "quantisation"
INSTABILITY = "bias instability"
WARM_UP = "warm-up"
TURN_ON = "turn-on"
REST_SCATTER = "scatter of the rests"
MOVE_SCATTER = "scatter of the moves"
CONING = "turning between samples"
SECOND_ORDER = "misalignment left open"
CUBE = "cube"
SLAB = "slab"
HEADING = "heading"
SEAT = "seats"
CLOSURE = "closure"
GRAVITY = "gravity"
FRAME = "frame held"
LATITUDE = "latitude"
CLOCK = "clock"
TEMPERATURE = "temperature"
EFFECTS = "effects added"
UNEXPLAINED = "unexplained"

# JCGM 100:2008, 4.2
TYPE_A = (COUNTING, INSTABILITY, TURN_ON, REST_SCATTER, MOVE_SCATTER, TEMPERATURE, EFFECTS, UNEXPLAINED)
SOURCES = (
    COUNTING, QUANTISATION, INSTABILITY, REST_SCATTER, MOVE_SCATTER, CONING, WARM_UP, TURN_ON, CUBE, SLAB,
    HEADING, SEAT, CLOSURE, GRAVITY, SECOND_ORDER, FRAME, LATITUDE, CLOCK, TEMPERATURE, EFFECTS, UNEXPLAINED,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SourceCell:
    """One estimate of a source's size: ``of`` says of what, ``dof`` how well the data tell it.

    All that scales with one estimate stands in one cell; cells are independent.
    """

    source: str
    of: str = ""
    dof: float = float("inf")


Shares = Mapping[SourceCell, FloatArray]
"""A variance (n,) split by cell: of rows, or of parameters."""


def added_shares(*parts: Shares) -> dict[SourceCell, FloatArray]:
    """Return shares (n,) added cell by cell; their unit is that of a variance."""
    total = dict[SourceCell, FloatArray]()
    for part in parts:
        for cell, variance in part.items():
            total[cell] = total[cell] + variance if cell in total else variance
    return total


def type_of(source: str) -> str:
    """Return the type of evaluation of JCGM 100:2008: A from the scatter of these data, B from what was stated."""
    return "A" if source in TYPE_A else "B"

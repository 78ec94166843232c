"""The sources of uncertainty by name, and the standard uncertainties of what a fit takes as given."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

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
    """One estimate of a source's size: ``of`` says of what, ``dof`` how well the data determine it.

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


@dataclass(frozen=True, slots=True, eq=False)
class Unexplained:
    """What a diagnosis could not explain of a triad.

    ``within`` is what drifts within its dwells, in squares of the counting noise of their means. ``moved`` (15,)
    bounds by how much k, E and D, each in its unit, are off for what effects took that is not theirs.
    """

    within: float = 0.0
    moved: FloatArray | None = None


ByTriad = Mapping[str, Unexplained]


@dataclass(frozen=True, slots=True)
class GivenValues:
    """1 sigma of what the fit takes as exact.

    ``latitude`` [rad]: 0.01 deg, 1.1 km, is what a map or two decimals leave open. It enters the Earth's rate;
    normal gravity's share of it, 9e-6 m/s2, is inside the 5e-4 m/s2 taken where no gravity is given.
    ``clock``, relative: the second of the recording's time column against the SI second; 1e-5 for a quartz
    that is good to 20 ppm (half width, a rectangular distribution has 0.58 of it as 1 sigma). Where a diagnosis
    put times right, it is the sigma of the rate that was found. A reference that shows nothing wrong does not make
    it smaller: nothing was put right, and the rate may be off by what was not seen.
    ``unexplained`` is what a diagnosis could not explain, by triad; None where it left nothing, or there was none.
    """

    latitude: float = float(np.radians(0.01))
    clock: float = 1e-5
    unexplained: ByTriad | None = None


EXACT = GivenValues(0.0, 0.0)

"""Why rests in unknown attitudes determine no bias and scale factor of each axis, and which rest would.

For the words alone: whether rests determine the unit is the fit's matter (`procedures.rests_and_moves.norm_fit`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES

OPPOSITE = 3.0  # times as far, in spans, as any other axis: the axis was turned over, as it is within 15 deg of it
NEVER_TURNED = 0.25  # of the largest span, below which an axis was never turned to the vertical
ONE_ATTITUDE = 0.5  # of the median norm: outputs that span less differ by a tilt, unless they have a large offset


class Lack(StrEnum):
    """What rests lack."""

    NO_RESTS = "no rests"
    FEW_RESTS = "few rests"
    SILENT = "a channel that does not respond"
    ONE_ATTITUDE = "one attitude"
    ONE_SIDED = "one side only"
    UNEQUAL = "specific forces of unequal length"
    UNCERTAIN = "too uncertain"


@dataclass(frozen=True, slots=True)
class Undetermined:
    """What ``rests``, so many, lack; of which ``axes``, or on which ``sides`` an axis was seen; ``excess`` [g]."""

    lack: Lack
    rests: int
    axes: tuple[str, ...] = ()
    sides: Mapping[str, str] = field(default_factory=dict)
    excess: float = 0.0

    @property
    def missing(self) -> list[str]:
        """Return what would determine the unit, with what was found, as phrases."""
        found = f"{self.rests} found"
        match self.lack:
            case Lack.NO_RESTS:
                return ["rests in which the unit is still for 2 s or longer (none found)"]
            case Lack.FEW_RESTS:
                return [f"6 rests, one on each face, or 10 that differ in attitude ({found})"]
            case Lack.SILENT:
                axes = ", ".join(self.axes)
                return [
                    f"accelerometer outputs that change with attitude ({axes}: the same in {self.rests} rests)"
                ]
            case Lack.ONE_ATTITUDE:
                return [f"rests on all six faces ({found}, all in nearly one attitude)"]
            case Lack.ONE_SIDED:
                return [_turned_over(axis, side) for axis, side in self.sides.items()]
            case Lack.UNEQUAL:
                by = f": it differs by {self.excess:.2g} g" if self.excess > 0 else ""
                return [
                    f"rests whose specific force has equal length ({found}{by}): hold still, on a surface that "
                    f"does not move, and check the accelerometers' columns"
                ]
            case Lack.UNCERTAIN:
                return [
                    f"longer rests, or more that turn accelerometer {', '.join(self.axes)} up and down ({found})"
                ]


def _turned_over(axis: str, side: str) -> str:
    """Return which rest an axis lacks, seen on one ``side`` ("up only", "down only") or "neither"."""
    wanted = {"up only": "down", "down only": "up"}.get(side, "up, and one with it down")
    return f"a rest with accelerometer {axis} pointing {wanted} (found: {side})"


def plainly_lacking(rate: FloatArray, least: int) -> Undetermined | None:
    """Say what rests with the mean outputs ``rate`` (n, 3) plainly lack; None where a fit is worth trying."""
    n = len(rate)
    if n == 0:
        return Undetermined(Lack.NO_RESTS, 0)
    span = np.ptp(rate, axis=0)
    if n > 1 and np.any(span == 0):
        return Undetermined(Lack.SILENT, n, tuple(AXES[i] for i in np.flatnonzero(span == 0)))
    if n >= least:
        return None
    found = undetermined(rate, Lack.FEW_RESTS)  # of rests far too few every axis lacks a side
    return Undetermined(Lack.FEW_RESTS, n) if found.lack is Lack.ONE_SIDED and n < least - 1 else found


def undetermined(rate: FloatArray, lack: Lack, axes: Sequence[str] = (), excess: float = 0.0) -> Undetermined:
    """Say why a fit to rests with the mean outputs ``rate`` (n, 3) failed.

    What the outputs show by themselves is said, else the ``lack``, ``axes`` and ``excess`` [g] that the fit found.
    """
    n, span = len(rate), np.ptp(rate, axis=0)
    if n > 1 and np.max(span) < ONE_ATTITUDE * np.median(np.linalg.norm(rate, axis=1)) and _is_one_tilted(span):
        return Undetermined(Lack.ONE_ATTITUDE, n)
    if n > 1 and (sides := _one_sided(rate, span)):
        return Undetermined(Lack.ONE_SIDED, n, tuple(sides), sides)
    return Undetermined(lack, n, tuple(axes), excess=excess)


def _is_one_tilted(span: FloatArray) -> bool:
    """Say whether the outputs change as about one attitude: along two axes by a tilt, along one by its square."""
    return int(np.sum(span < NEVER_TURNED * np.max(span))) == 1


def _one_sided(rate: FloatArray, span: FloatArray) -> dict[str, str]:
    """Return the axes that no two rests turn over, and on which side each was seen."""
    found = dict[str, str]()
    apart = np.abs(rate[:, None] - rate) / span
    for i, axis in enumerate(AXES):
        others = np.max(np.delete(apart, i, axis=2), axis=2)
        turned = span[i] >= NEVER_TURNED * np.max(span)
        if turned and np.any((apart[..., i] > 0.5) & (apart[..., i] > OPPOSITE * others)):
            continue
        above, below = np.max(rate[:, i]) - np.median(rate[:, i]), np.median(rate[:, i]) - np.min(rate[:, i])
        found[axis] = "neither" if not turned else "up only" if above > below else "down only"
    return found

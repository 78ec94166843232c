"""Values that are wrong by what nobody can notice: a crumb that the program names, a cube off its marks.

Each campaign also says from which lean on a cube would show in each dwell, and by how many sigmas a smaller one
moves a value.

Of a cube that slips on the slab once it was set along the marks, before it is recorded, no sensor tells: the
campaign states how well marks are met, and the budget has the gyroscopes' share of it.
"""

import re
from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

from procedures.frames import AXES
from procedures.units import RAD_PER_ARCSEC

MOST_SIGMAS = 4.0  # sigmas of a value, that no lean moves, by which it is a finding
SURELY = 5.0  # times what is stated
MARGIN = 1.5  # a tilt of the size that is stated fails the global test every second time only
REPORTED = re.compile(r"(?:not be noticed|;) in positions? ([^:]+): (accelerometer|gyroscope)(.*?)would be wrong")
PLACE = re.compile(r"(\d+) \((any size|up to (\d+) arcsec)\)")
VALUES = [f"k {a}" if a == b else f"E {a}{b}" for a in AXES for b in AXES]
BIASES = [f"D {axis}" for axis in AXES]


def unreported_by_heading(turned: Mapping[str, float], heading_std: float) -> dict[str, str]:
    """Return the gyroscopes' values where a cube was ``turned`` [rad] off its marks by far more than is stated."""
    off, name = max(((angle, name) for name, angle in turned.items()), default=(0.0, ""))
    if off <= SURELY * heading_std:
        return {}
    stated = f"{degrees(heading_std):.2g}"
    why = f"{name} stood {degrees(off):.2f} deg off its marks, which are said to be met to {stated}"
    return {f"gyroscope {value}": why for value in VALUES}


def unreported_by_size(
    reported: Sequence[Mapping[str, Any]], tilts: Mapping[str, float], sigmas: Mapping[str, float]
) -> dict[str, str]:
    """Return which values are off by more than `MOST_SIGMAS` and less than that and what an unnoticed lean does.

    ``reported`` are the ``unnoticed_leans`` of `solution/1`, ``tilts`` [rad] the true ones of the dwells, counted
    up to `MARGIN` times what shows, ``sigmas`` by how much of its own sigma each value of either triad is off.
    """
    unreported = dict[str, str]()
    for each in reported:
        name, shows = f"dwell_{each['position']:02d}", each["lean_arcsec"]
        tilt = tilts.get(name, 0.0) / RAD_PER_ARCSEC
        if 3 < tilt < MARGIN * shows:
            why = f"{name} stood {tilt:.0f} arcsec off, where {shows:.0f} show"
            far = [title for title, off in sigmas.items() if MOST_SIGMAS < abs(off) < MOST_SIGMAS + each["sigmas"]]
            unreported |= dict.fromkeys(far, why)
    return unreported


def unreported_values(warnings: Sequence[str], tilts: Mapping[str, float]) -> dict[str, str]:
    """Return which values no other dwell could tell, by title, and why; ``tilts`` [rad] are the dwells' true ones.

    They are scale factor and misalignment, or bias too, of the triad of which the program says so, where the cube
    stood askew in one of the positions that it names, by no more than it says would not be noticed.
    """
    unreported = dict[str, str]()
    for places, triad, what in (found for text in warnings for found in REPORTED.findall(text)):
        for position, _, size in PLACE.findall(places):
            tilt = tilts.get(f"dwell_{int(position):02d}", 0.0) / RAD_PER_ARCSEC
            if 3 < tilt < MARGIN * float(size or "inf"):
                why = f"position {position} stood {tilt:.0f} arcsec off, which would not be noticed"
                unreported |= {f"{triad} {name}": why for name in (*VALUES, *(BIASES if "bias" in what else []))}
    return unreported

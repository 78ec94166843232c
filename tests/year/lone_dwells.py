"""Values that lean on a dwell which the program itself called alone or unchecked, and which stood askew."""

import re
from collections.abc import Mapping, Sequence

from procedures.frames import AXES, face_of
from procedures.units import RAD_PER_ARCSEC

GYROSCOPE = [f"k {axis}" for axis in AXES] + [f"E {one}{other}" for one in AXES for other in AXES if one != other]

# rad: three of the seats' 1 sigma that a campaign states, and what dwells of some seconds tell of a bias
SEAT_RAD, MOST_UNTOLD_RAD = 3 * RAD_PER_ARCSEC, 20 * RAD_PER_ARCSEC
OF_COUNT_RAD = 1e-3  # a turn by this is a count per second of level sensors of about 1000 count/(g s)
ALONE = re.compile(r"alone with their face up: positions? ([\d, ]+);")
MOVED = re.compile(r"gyroscope scale factor and misalignment by the moves")
FEW_EDGES = re.compile(r"position (\d+): accelerometer \w shows .* lie in \[(\S+), (\S+)\] count/s")
UNCHECKED = re.compile(r"nothing checks positions? ([\d, ]+):")


def untold_values(warnings: Sequence[str], leans: Mapping[str, float]) -> dict[str, str]:
    """Return which values no other seat could tell, by title, and why; ``leans`` [rad] are the dwells' true ones.

    They are the misalignments of the level sensors alone, in the dwells that the warnings name, and what the
    gyroscope has by moves from and to them. Beyond `MOST_UNTOLD_RAD`, or what a level sensor of few count edges
    leaves open, the biases that other faces know contradict it, and the verdict has to say so; nothing does
    where the program says that nothing checks the position, and there k of the level sensors leans, too.
    """
    unchecked, untold = _named(UNCHECKED, warnings), dict[str, str]()
    most = _left_open(warnings)
    for position in [*_named(ALONE, warnings), *unchecked]:
        lean = leans.get(f"dwell_{position:02d}", 0.0)
        if SEAT_RAD < lean and (lean < max(MOST_UNTOLD_RAD, most.get(position, 0.0)) or position in unchecked):
            up = face_of(position)[0]
            said = "unchecked" if position in unchecked else "alone"
            why = f"position {position}, said to be {said}, stood {lean / RAD_PER_ARCSEC:.0f} arcsec off"
            level = [sensor for sensor in AXES if sensor != up]
            untold |= {f"accelerometer E {sensor}{up}": why for sensor in level}
            if any(map(MOVED.search, warnings)):
                untold |= {f"gyroscope {name}": why for name in GYROSCOPE}
            if lean > MOST_UNTOLD_RAD:  # k is the length of a row that holds E: at second order it leans, too
                untold |= {f"accelerometer k {sensor}": why for sensor in level}
    return untold


def _left_open(warnings: Sequence[str]) -> dict[int, float]:
    """Return by how much a dwell's cube may lean [rad], by position, for level sensors that passed few counts."""
    found = [each for text in warnings for each in FEW_EDGES.findall(text)]
    return {int(number): (float(high) - float(low)) * OF_COUNT_RAD for number, low, high in found}


def _named(said: re.Pattern[str], warnings: Sequence[str]) -> list[int]:
    return [int(each) for text in warnings for found in said.findall(text) for each in found.split(",")]

"""Values that lean on a dwell which the program itself called alone with its face up, and which stood askew."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from procedures.frames import AXES, face_of
from procedures.units import RAD_PER_ARCSEC

# rad: three of the seats' 1 sigma that a campaign states, and what dwells of some seconds tell of a bias
SEAT_RAD, MOST_UNTOLD_RAD = 3 * RAD_PER_ARCSEC, 20 * RAD_PER_ARCSEC
UNCHECKED = "nothing checks them"
SAID = re.compile(r"alone with their face up: positions? ([\d, ]+);")


def untold_values(warnings: Sequence[str], leans: Mapping[str, float]) -> dict[str, str]:
    """Return which values no other seat could tell, by title, and why; ``leans`` [rad] are the dwells' true ones.

    They are the misalignments of the level sensors alone, in the dwells that the warnings name. Beyond
    `MOST_UNTOLD_RAD` the biases that other faces know contradict it, and the verdict has to say so; nothing does
    where the program says that nothing checks the dwells, as of a unit switched off and on after every other.
    """
    most = np.inf if any(UNCHECKED in text for text in warnings) else MOST_UNTOLD_RAD
    named = [int(each) for text in warnings for found in SAID.findall(text) for each in found.split(",")]
    untold = dict[str, str]()
    for position in named:
        lean = leans.get(f"dwell_{position:02d}", 0.0)
        if SEAT_RAD < lean < most:
            up = face_of(position)[0]
            why = f"position {position}, said to be alone, stood {lean / RAD_PER_ARCSEC:.0f} arcsec off"
            untold |= {f"accelerometer E {sensor}{up}": why for sensor in AXES if sensor != up}
    return untold

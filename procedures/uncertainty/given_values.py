"""What a fit takes as given: how well it is known."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Unexplained:
    """What a diagnosis could not explain of a triad.

    ``within`` is what wanders within its dwells, in squares of the counting noise of their means. ``moved`` (15,)
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

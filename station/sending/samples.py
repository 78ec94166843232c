"""Calibrated samples as every output takes them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedSamples:
    """Consecutive samples, n of them.

    ``sequence`` (n,) rises by 1 with each sample that is handed on, so that a jump is a loss on the way from here.
    ``t`` (n,) is device time [s] at the end of the sample's interval, ``utc`` (n,) [s since 1970], nan where not
    known, ``taken_ns`` (n,) when it was taken by this machine's clock [ns since 1970]. ``f`` (n, 3) is specific
    force [m/s2], ``omega`` (n, 3) angular rate [rad/s], in the axes asked for; ``temperature`` (n,) [degC] or nan.
    ``flags`` (n,) are `station.sending.quality.Quality`, ``lost`` (n,) how many samples the device's counter
    misses before each.
    """

    sequence: IntArray
    t: FloatArray
    utc: FloatArray
    taken_ns: IntArray
    f: FloatArray
    omega: FloatArray
    temperature: FloatArray
    flags: NDArray[np.uint32]
    lost: IntArray

    def __len__(self) -> int:
        return len(self.sequence)


@dataclass(frozen=True, slots=True, eq=False)
class About:
    """What is the same of all samples: whose they are, by which calibration, in which axes.

    ``C`` (3, 3) takes the axes that are handed on to forward-right-down; ``period`` is in s.
    """

    model: str
    serial: str
    calibration: str
    axes: str
    C: FloatArray
    period: float

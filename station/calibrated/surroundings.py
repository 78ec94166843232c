"""What a calibration is applied with: what the sensors were in, and a triad's numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.calibrated.temperature_signals import TemperatureSignals


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the sensors were in at n samples, each (n,) or (n, 3), None where unknown.

    ``temperature`` [degC], ``temperature_rate`` [K/min], ``magnetic`` [uT] in IMU axes, ``auxiliary`` by channel;
    ``t`` [s] rises. ``signals`` are what a `TemperatureFollower` makes of the temperature, where it was followed
    before; else it begins with the first sample.
    """

    temperature: FloatArray | None = None
    temperature_rate: FloatArray | None = None
    magnetic: FloatArray | None = None
    auxiliary: Mapping[str, FloatArray] = field(default_factory=dict)
    t: FloatArray | None = None
    signals: TemperatureSignals | None = None

    @property
    def followed(self) -> TemperatureSignals:
        """Its signals, which are there by now."""
        assert self.signals is not None
        return self.signals


@dataclass(frozen=True, slots=True, eq=False)
class Triad:
    """k (3,), E (3, 3), D (3,) in g or deg/s, and ``inverse`` (3, 3) of E."""

    k: FloatArray
    E: FloatArray
    D: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, part: Mapping[str, Any], per: float) -> "Triad":
        """Return a triad of `calibration/1` whose bias is in 1 / ``per`` of the unit of u."""
        names = ("scale_factor", "misalignment", "bias")
        k, E, D = (np.array(part[name]["value"], dtype=np.float64) for name in names)
        return cls(k, E, D * per, np.asarray(np.linalg.inv(E), np.float64))


NOTHING_KNOWN = Surroundings()

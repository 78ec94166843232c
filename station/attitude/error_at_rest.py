"""The errors of a unit at rest on a level slab, with its calibration and without it.

At rest the specific force has one size and points along a face's axis if the slab is level, and the gyros show
the Earth's rotation. What is left is the error of the reading: of level [deg], of drift [deg/h], of g [mg].
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.geodesy import EARTH_RATE
from procedures.units import DEG_H_PER_RAD_S, STANDARD_GRAVITY
from station.attitude.live_readings import RestErrorComparison, RestErrors
from station.calibrated.rates_and_forces import CalibratedTick, RatesAndForces

MIN_COMPARED_REST_S = 2.0
MOVED_FORCE = 0.1  # m/s2, of a tick's mean from that of the rest so far
MOVED_RATE = np.radians(0.5)  # rad/s
NEAR_FACE_COS = np.cos(np.radians(20.0))  # to a face, beyond which there is no level to compare with
M_S2_PER_MG = 1e-3 * STANDARD_GRAVITY


class ErrorAtRest:
    """Sums over one rest; ``latitude`` [rad] and ``heading`` [rad] of forward as known, else None.

    ``quantum`` [m/s2] is a count's worth of a tick's specific force.
    """

    def __init__(
        self, gravity: float, latitude: float | None, heading: float | None, quantum: float = 0.0
    ) -> None:
        self._moved = MOVED_FORCE + 2 * quantum
        self._gravity, self._latitude, self._heading = gravity, latitude, heading
        self._sums: dict[str, FloatArray] = {}
        self._n, self._seconds = 0, 0.0

    def reset(self) -> None:
        """Forget this rest."""
        self._sums, self._n, self._seconds = {}, 0, 0.0

    def take(self, tick: CalibratedTick, seconds: float, *, rests: bool) -> None:
        """Take a tick; where the unit does not rest, or has been moved since, restart."""
        if self._n and (not rests or self._has_moved(tick.calibrated)):
            self.reset()
        if not rests:
            return
        for name, inputs in (("with", tick.calibrated), ("without", tick.nominal)):
            added = np.stack([inputs.rate.sum(axis=0), inputs.force.sum(axis=0)])
            self._sums[name] = self._sums.get(name, np.zeros((2, 3))) + added
        self._n += len(tick.t)
        self._seconds += seconds

    @property
    def comparison(self) -> RestErrorComparison | None:
        """Both sides; None before 2 s of rest."""
        if self._seconds < MIN_COMPARED_REST_S:
            return None
        return RestErrorComparison(self._seconds, self._side("with"), self._side("without"), self._known())

    def _side(self, name: str) -> RestErrors:
        rate, force = self._sums[name] / self._n
        size = float(np.linalg.norm(force))
        nearest = float(np.abs(force).max()) / size
        level = float(np.degrees(np.arccos(min(nearest, 1.0)))) if nearest > NEAR_FACE_COS else float("nan")
        reference = self._sums["with"][1]  # one vertical for both: drift is the gyros' affair
        return RestErrors(
            level, self._drift(rate, -reference / np.linalg.norm(reference)), (size - self._gravity) / M_S2_PER_MG
        )

    def _drift(self, rate: FloatArray, down: FloatArray) -> float:
        """Return a rate (3,) less the Earth's [deg/h], as far as that is known."""
        if self._latitude is None:
            return float(np.linalg.norm(rate) * DEG_H_PER_RAD_S)
        below = float(rate @ down)
        across = rate - below * down
        north, off_down = EARTH_RATE * np.cos(self._latitude), below + EARTH_RATE * np.sin(self._latitude)
        if self._heading is not None and abs(down[0]) < NEAR_FACE_COS:
            ahead = np.array([1.0, 0.0, 0.0]) - down[0] * down
            ahead /= np.linalg.norm(ahead)
            right = np.cross(down, ahead)
            across = across - north * (np.cos(self._heading) * ahead - np.sin(self._heading) * right)
            level = float(np.linalg.norm(across))
        else:
            level = float(np.linalg.norm(across)) - north
        return float(np.hypot(level, off_down) * DEG_H_PER_RAD_S)

    def _known(self) -> str:
        if self._latitude is None:
            return "drift includes the Earth's rate: no --latitude"
        if self._heading is None:
            return "Earth's rate corrected, its level part by size"
        return "the Earth's rate is corrected"

    def _has_moved(self, inputs: RatesAndForces) -> bool:
        rate, force = self._sums["with"] / self._n
        far = np.linalg.norm(inputs.force.mean(axis=0) - force) > self._moved
        return bool(far or np.linalg.norm(inputs.rate.mean(axis=0) - rate) > MOVED_RATE)

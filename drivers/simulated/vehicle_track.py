"""Where a simulated vehicle goes: a smooth line through points in time, level East-North-Up [m] from its site.

Between points that are the same it stands (cubic Hermite interpolation without overshoot: Fritsch, Butland 1984).
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

from drivers.errors import TruthRefused
from drivers.simulated.cube_motion import Segment
from procedures.arrays import FloatArray
from procedures.units import STANDARD_GRAVITY

MIN_SPEED_M_S = 0.2  # m/s, below which the vehicle keeps its heading
EXPECTED = "two rows or more t_s,e_m,n_m,u_m after a header"


@dataclass(frozen=True, slots=True, eq=False)
class VehicleTrack:
    """Points ``enu`` (n, 3) [m] at times ``t`` (n,) [s]; it stands at the first before and at the last after."""

    t: FloatArray
    enu: FloatArray
    _line: PchipInterpolator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.t).all() and np.isfinite(self.enu).all()):
            raise TruthRefused("a track with a number that is not finite", "finite times and places")
        if len(self.t) < 2 or self.enu.shape != (len(self.t), 3) or not np.all(np.diff(self.t) > 0):
            raise TruthRefused(
                f"a track of shape {self.enu.shape}", "two rows or more t_s,e_m,n_m,u_m, t_s increasing"
            )
        object.__setattr__(self, "_line", PchipInterpolator(self.t, self.enu))

    def position(self, t: float) -> FloatArray:
        """Return the place (3,) [m] at time ``t`` [s]."""
        place: FloatArray = self.positions(np.array([t]))[0]
        return place

    def velocity(self, t: float) -> FloatArray:
        """Return the velocity (3,) [m/s] at time ``t`` [s]."""
        v: FloatArray = self.velocities(np.array([t]))[0]
        return v

    def positions(self, t: FloatArray) -> FloatArray:
        """Return the places (n, 3) [m] at times (n,) [s]."""
        return np.asarray(self._line(np.clip(t, self.t[0], self.t[-1])), dtype=np.float64)

    def velocities(self, t: FloatArray) -> FloatArray:
        """Return the velocities (n, 3) [m/s] at times (n,) [s]."""
        inside = (t >= self.t[0]) & (t < self.t[-1])
        v: FloatArray = np.where(inside[:, None], self._line(np.clip(t, self.t[0], self.t[-1]), 1), 0.0)
        return v


def load_track(text: str) -> VehicleTrack:
    """Return the track of a CSV text ``t_s,e_m,n_m,u_m``; raise `TruthRefused` where it is none."""
    lines = [line for line in text.splitlines()[1:] if line.partition("#")[0].strip()]
    if not lines:
        raise TruthRefused("no rows", EXPECTED)
    try:
        rows = np.loadtxt(lines, delimiter=",", ndmin=2)
    except ValueError as error:
        raise TruthRefused(str(error), EXPECTED) from error
    if rows.shape[1] != 4:
        raise TruthRefused(f"{rows.shape[1]} columns", "t_s,e_m,n_m,u_m")
    return VehicleTrack(rows[:, 0], rows[:, 1:])


def drive(track: VehicleTrack, C_bn: FloatArray, first: int, period: float) -> Segment:
    """Return the drive along a track from sample ``first`` on, the x axis of the cube ahead; ``period`` [s].

    ``C_bn`` (3, 3) is an attitude with x level; at the first sample the cube is put on its course.

    Raises `TruthRefused` if the track is over by then.
    """
    samples = int(np.ceil(track.t[-1] / period)) - first + 1
    if samples < 1:
        raise TruthRefused(f"a track that ended at {track.t[-1]:g} s", "one that goes on")
    t: FloatArray = np.float64(period) * np.arange(first, first + samples + 1)
    v = track.velocities(t)
    accel_n = np.diff(v, axis=0) / (period * STANDARD_GRAVITY)
    return Segment(C_bn, samples, C_bn[:, 2], turn_angle(t, v, C_bn), accel_n)


def turn_angle(t: FloatArray, v: FloatArray, C_bn: FloatArray) -> FloatArray:
    """Return by how much (n,) [rad] the cube has turned about its up.

    Parameters
    ----------
    t, v
        (n,) [s] and (n, 3) [m/s], times and velocities, East-North-Up.
    C_bn
        (3, 3), the attitude that it begins with.
    """
    moves = np.hypot(v[:, 0], v[:, 1]) > MIN_SPEED_M_S
    if not moves.any():
        return np.zeros(len(t))
    course: FloatArray = np.unwrap(np.arctan2(v[moves, 1], v[moves, 0]))
    angle: FloatArray = np.interp(t, t[moves], course) - np.arctan2(C_bn[0, 1], C_bn[0, 0])
    return angle

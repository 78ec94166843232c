"""A cube carried in a level vehicle along a track: it turns with the course and feels the velocity change."""

import numpy as np

from drivers.simulated.cube_motion import Segment
from drivers.simulated.errors import TruthRefused
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.arrays import FloatArray
from procedures.units import STANDARD_GRAVITY

MIN_SPEED_M_S = 0.2  # m/s, below which the vehicle keeps its heading


def drive(track: VehicleTrack, C_bn: FloatArray, first: int, period: float) -> Segment:
    """Return the drive along a track from sample ``first`` on, the x axis of the cube ahead; ``period`` [s].

    ``C_bn`` (3, 3) is an attitude with x level; at the first sample the cube is put on its course.

    Raises
    ------
    TruthRefused
        If the track is over by then.
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

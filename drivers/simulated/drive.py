"""A cube carried in a level vehicle along a track: it turns with the course and feels the velocity change."""

import numpy as np

from drivers.simulated.errors import TruthRefused
from drivers.simulated.motion import Segment
from drivers.simulated.track import Track
from procedures.arrays import FloatArray
from procedures.earth import STANDARD_GRAVITY

SLOWEST = 0.2  # m/s, below which the vehicle keeps its heading


def drive(track: Track, C_bn: FloatArray, first: int, period: float) -> Segment:
    """Return the drive along a track from sample ``first`` to its end, the x axis of the cube ahead.

    ``C_bn`` (3, 3) is an attitude with x level; at the first sample the cube is put on its course.

    Raises
    ------
    TruthRefused
        If the track is over by then.
    """
    samples = int(np.ceil(track.t[-1] / period)) - first + 1
    if samples < 1:
        raise TruthRefused(f"a track that ended at {track.t[-1]:g} s", "one that goes on")
    ahead_n = C_bn[0]
    t: FloatArray = np.float64(period) * np.arange(first, first + samples + 1)
    v = track.velocities(t)
    moves = np.hypot(v[:, 0], v[:, 1]) > SLOWEST
    angle = np.zeros(samples + 1)
    if moves.any():
        course: FloatArray = np.unwrap(np.arctan2(v[moves, 1], v[moves, 0]))
        angle[:] = np.interp(t, t[moves], course) - np.arctan2(ahead_n[1], ahead_n[0])
    accel_n = np.diff(v, axis=0) / (period * STANDARD_GRAVITY)
    return Segment(C_bn, samples, C_bn[:, 2], angle, accel_n)

"""What latitude and time base do to the parameters: changes of the rows (n,) per unit, through the fit's gain.

*Latitude.* The gyroscopes' model has the Earth's rate in it, ``w = Omega (0, cos lat, sin lat)``; an error of the
latitude changes dwells by ``K C w'`` and turns by ``K C M w'``, with ``w' = Omega (0, -sin lat, cos lat)``.

*Clock.* Let the files' second be too short by the part e of itself: a rate of counts comes out too small by e.
Counting accelerometers: all rates scale, so k does and E and D do not. Counting gyroscopes: dwells scale; a turn's
total does not, but the bias and the Earth's rate have acted longer than its time says. Where the unit puts out
rates it is the other way round: dwells stay, the integral of a turn scales but for bias and Earth.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.gyroscopes_joint_fit import GyroscopeFit
from procedures.earth.gravity_and_rate import EARTH_RATE, earth_rate_n


def latitude_rows(gyroscope: GyroscopeFit) -> FloatArray:
    """Return the change of the whitened rows (n,) per radian of latitude."""
    campaigns = gyroscope.joint.bench.campaigns
    change = [
        np.degrees(EARTH_RATE) * np.array([0.0, -np.sin(c.site.latitude), np.cos(c.site.latitude)])
        for c in campaigns
    ]
    return _whitened(gyroscope, _felt(gyroscope, change) @ gyroscope.joint.K.T)


def clock_rows(gyroscope: GyroscopeFit, rate_output: bool) -> FloatArray:
    """Return the change of the whitened rows (n,) per relative error of the time base."""
    joint = gyroscope.joint
    earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in joint.bench.campaigns]
    n = len(joint.seen.dwells)
    seconds = np.concatenate((np.ones(n), [turn.seconds for turn in gyroscope.turns]))
    timed = _felt(gyroscope, earth) @ joint.K.T + seconds[:, None] * joint.b
    if rate_output:
        timed[:n] = 0.0
        timed[n:] -= np.array([turn.total for turn in gyroscope.turns]).reshape(-1, 3)
    return _whitened(gyroscope, timed)


def _felt(gyroscope: GyroscopeFit, vector_n: list[FloatArray]) -> FloatArray:
    """Return (m, 3) what every dwell, then every turn's integral, has of each campaign's vector, IMU axes."""
    joint = gyroscope.joint
    bench, n = joint.bench, len(joint.seen.dwells)
    motion = np.stack([np.eye(3)] * n + [shape.motion for shape in gyroscope.geometry])
    return bench.seen_by_imu(joint.fit.x[12 : 12 + bench.size], vector_n, motion)


def _whitened(gyroscope: GyroscopeFit, change: FloatArray) -> FloatArray:
    sigma = np.concatenate((gyroscope.joint.sigma, gyroscope.turn_sigma))
    rows = np.zeros(len(gyroscope.joint.fit.residual))
    rows[: change.size] = (change / sigma).ravel()
    return rows


def clock_on_accelerometer(value: FloatArray, counts: bool) -> FloatArray:
    """Return the change of k, E, D, ``value`` (15,), per relative error of the time base."""
    return np.concatenate((value[:3] * counts, np.zeros(12)))


def clock_on_moves(value: FloatArray, counts: bool) -> FloatArray:
    """Return the change of gyroscopes' k, E, D by moves, ``value`` (15,): D of counts, k (and so D) of rates."""
    k, D = (np.zeros(3), value[12:]) if counts else (value[:3], value[12:])
    return np.concatenate((k, np.zeros(9), D))

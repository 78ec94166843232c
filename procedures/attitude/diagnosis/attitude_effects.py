"""What a mixer's model may lack: columns that an effect adds to rates and specific forces along a log.

A column is what a unit of the coefficient adds to what is measured, beyond the base model: nothing but gravity
without a speed, ``omega x (V, 0, 0)`` with one.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.frames import AXES

SMOOTH_S = 0.2  # of what is differentiated


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeMotion:
    """A log as effects see it: rates and forces as measured, speed V (n,) [m/s] (zero where none is known)."""

    log: AttitudeLog
    speed: FloatArray
    speed_slope: FloatArray
    rate_slope: FloatArray

    @classmethod
    def of(cls, log: AttitudeLog, speed: FloatArray) -> "AttitudeMotion":
        """Differentiate what needs it, smoothed over `SMOOTH_S`."""
        rows = max(round(SMOOTH_S / log.nominal), 1)
        return cls(log, speed, slope(speed[:, None], log.t, rows)[:, 0], slope(log.omega_b, log.t, rows))


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeEffect:
    """A cause: its coefficients, unit, 1 sigma of what they may plausibly be, and its columns.

    ``rate`` and ``force`` return (n, 3, k) [rad/s], [m/s2] a unit, None where it adds nothing. ``needs_truth``
    where gyros and accelerometers alone cannot show it, ``needs_speed`` where a speed is part of it;
    ``of_velocity`` where a filter that estimates velocity holds it already. ``is_of_aid``: it is taken off the
    speed itself.
    """

    name: str
    coefficients: tuple[str, ...]
    unit: str
    plausible: float
    separate_by: str
    rate: Callable[[AttitudeMotion], FloatArray] | None = None
    force: Callable[[AttitudeMotion], FloatArray] | None = None
    needs_truth: bool = False
    needs_speed: bool = False
    of_velocity: bool = False
    is_of_aid: bool = False


def slope(values: FloatArray, t: FloatArray, rows: int) -> FloatArray:
    """Return the derivative of ``values`` (n, k) by ``t`` (n,) [s], each column a running mean over ``rows``."""
    kernel = np.ones(rows) / rows
    padded = np.pad(values, ((rows // 2, rows - 1 - rows // 2), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=1)
    found: FloatArray = np.gradient(smooth, t, axis=0)
    return found


def _unit(motion: AttitudeMotion) -> FloatArray:
    return np.broadcast_to(np.eye(3), (len(motion.log.t), 3, 3))


def _per_axis(values: FloatArray) -> FloatArray:
    return values[:, :, None] * np.eye(3)


def _crossed(values: FloatArray) -> FloatArray:
    """Return columns (n, 3, 3) of a small rotation vector that turns vectors (n, 3) as the IMU sees them."""
    return np.cross(np.eye(3)[None], values[:, None, :]).transpose(0, 2, 1)


def _turning(motion: AttitudeMotion, axis: int, speed: FloatArray) -> FloatArray:
    """Return ``omega x V e_axis`` as one column (n, 3, 1)."""
    return np.cross(motion.log.omega_b, speed[:, None] * np.eye(3)[axis])[:, :, None]


def _lever(motion: AttitudeMotion) -> FloatArray:
    w, axes = motion.log.omega_b[:, None, :], np.eye(3)[None]
    found = np.cross(motion.rate_slope[:, None, :], axes) + np.cross(w, np.cross(w, axes))
    return found.transpose(0, 2, 1)


def _along_x(motion: AttitudeMotion) -> FloatArray:
    column = np.zeros((len(motion.log.t), 3, 1))
    column[:, 0, 0] = motion.speed_slope
    return column


TURN = "turns both ways at two speeds"
ATTITUDE_EFFECTS = (
    AttitudeEffect("velocity.forward", ("value",), "1", 1.0, TURN, needs_speed=True,
                   force=lambda m: _turning(m, 0, m.speed)),
    AttitudeEffect("velocity.attack", ("value",), "rad", 0.1, "rolling in and out of turns", needs_speed=True,
                   of_velocity=True, force=lambda m: _turning(m, 2, m.speed)),
    AttitudeEffect("velocity.slip", ("value",), "rad", 0.05, "rolling and pitching at speed", needs_speed=True,
                   of_velocity=True, force=lambda m: _turning(m, 1, m.speed)),
    AttitudeEffect("velocity.rate", ("value",), "1", 1.0, "braking and speeding up on a straight line",
                   needs_speed=True, of_velocity=True, force=_along_x),
    AttitudeEffect("aid.scale", ("value",), "1", 0.1, TURN, needs_speed=True, is_of_aid=True,
                   force=lambda m: _turning(m, 0, m.speed)),
    AttitudeEffect("aid.time_offset", ("value",), "s", 0.5, "turns while the speed changes", needs_speed=True,
                   is_of_aid=True, force=lambda m: _turning(m, 0, m.speed_slope)),
    AttitudeEffect("mounting.angle", AXES, "rad", 0.02, "rests far apart in roll and pitch", needs_truth=True,
                   rate=lambda m: _crossed(m.log.omega_b), force=lambda m: _crossed(m.log.f_b)),
    AttitudeEffect("mounting.lever_arm", AXES, "m", 1.0, "fast turning on the spot", force=_lever),
    AttitudeEffect("gyroscope.bias", AXES, "rad/s", 0.02, "a minute of rest", rate=_unit),
    AttitudeEffect("gyroscope.scale", AXES, "1", 0.01, "closed turns about each axis",
                   rate=lambda m: _per_axis(m.log.omega_b)),
    AttitudeEffect("accelerometer.bias", AXES, "m/s2", 0.1, "rests in opposite positions", force=_unit),
)  # fmt: skip

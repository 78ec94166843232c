"""How the cube moves: rests, flips and manual rotations, as rotations about an axis fixed in the cube.

Attitudes ``C_bn`` (3, 3) take East-North-Up to the cube, ``target_C_bn`` (3, 3) is the last one of a move.

A `Segment` turns the cube by ``angle(t)`` about ``axis_b`` from its first attitude. The increments a gyro
integrates are differences of that angle, so a closed turn integrates exactly; vectors fixed in n are averaged
over each sample (exact for a steady rate within the sample). The lever arm from the axis is zero.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation

SETTLED_TAUS = 12.0  # a settling is cut where it is 6e-6 of its amplitude
TURN_RATE_DEG_S = 35.0  # mean speed of a hand turn
LIFT_G = 0.03  # peak acceleration of the lift
TREMBLE_G = 0.003  # what a hand adds while it holds the cube


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A stretch of motion of ``samples`` samples, or open-ended if None (then at rest).

    ``C_bn`` (3, 3) is the attitude at its start; ``angle`` (samples + 1,) [rad] about ``axis_b`` (3,) at the
    edges of the samples, None at rest; ``accel_n`` (samples, 3) [g] added to gravity's specific force.
    ``position`` is where the cube is said to rest, 0 while moved; ``rested`` the samples since it came to rest.
    """

    C_bn: FloatArray
    samples: int | None = None
    axis_b: FloatArray | None = None
    angle: FloatArray | None = None
    accel_n: FloatArray | None = None
    position: int = 0
    rested: int | None = None

    def end_C_bn(self) -> FloatArray:
        """Return the attitude (3, 3) at the segment's end."""
        if self.angle is None or self.axis_b is None:
            return self.C_bn
        return rotation(-self.angle[-1] * self.axis_b) @ self.C_bn

    def seen(self, vector_n: FloatArray, first: int, last: int) -> FloatArray:
        """Return ``vector_n`` (3,) or (samples, 3) as seen in the cube, mean over samples: (n, 3) or (1, 3)."""
        if vector_n.ndim == 2:
            vector_n = vector_n[first:last]
        vector_b: FloatArray = np.einsum("bn,...n->...b", self.C_bn, vector_n)
        if self.angle is None or self.axis_b is None:
            return vector_b.reshape(-1, 3)
        edges = self.angle[first : last + 1, None]
        middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
        spread = np.sinc(half / np.pi)
        along = np.einsum("b,...b->...", self.axis_b, vector_b)[..., None] * self.axis_b
        across = vector_b - along
        # the cube turns by +angle, so what is fixed in n turns by -angle as seen in it
        rotated: FloatArray = spread * (np.cos(middle) * across - np.sin(middle) * np.cross(self.axis_b, across))
        rotated += along
        return rotated

    def rate_b(self, first: int, last: int, period: float) -> FloatArray:
        """Return the mean rate (n, 3) or (1, 3) [rad/s] of b relative to n over each sample, resolved in b."""
        if self.angle is None or self.axis_b is None:
            return np.zeros((1, 3))
        rate: FloatArray = np.diff(self.angle[first : last + 1])[:, None] / period * self.axis_b
        return rate


def rest(C_bn: FloatArray, samples: int | None, position: int, rested: int = 0) -> Segment:
    """Return a rest in an attitude [rotation]; ``rested`` samples of it have already passed."""
    return Segment(C_bn, samples, position=position, rested=rested)


def settle(
    C_bn: FloatArray, position: int, period: float, rng: np.random.Generator, size: float, tau_s: float, hz: float
) -> Segment:
    """Return the first moments after a flip: the tilt ``size exp(-t / tau_s) sin(2 pi hz t)`` [rad] dies away."""
    samples = int(np.ceil(SETTLED_TAUS * tau_s / period))
    t = period * np.arange(samples + 1)
    axis_n = np.append(_unit(rng.standard_normal(2)), 0.0)
    angle = size * np.exp(-t / tau_s) * np.sin(2 * np.pi * hz * t)
    angle[-1] = 0.0
    return Segment(C_bn, samples, C_bn @ axis_n, angle, position=position, rested=0)


def flip(
    C_bn: FloatArray, target_C_bn: FloatArray, samples: int, period: float, rng: np.random.Generator
) -> Segment:
    """Return a move by hand from one attitude to another: grip, lift, rotate, set down, let go; ``period`` [s].

    The cube turns about the one axis that leads from first to last attitude, smoothly (quintic), in the middle
    half of the move; the hand trembles all along, and a lift and a setting down show in specific force.
    """
    axis, full = axis_angle(C_bn @ target_C_bn.T)
    u = np.linspace(0.0, 1.0, samples + 1)
    s = np.clip((u - 0.25) / 0.5, 0.0, 1.0)
    angle = full * s**3 * (10 - 15 * s + 6 * s**2)
    return Segment(C_bn, samples, axis, angle, hand_forces(samples, period, rng))


def hand_forces(samples: int, period: float, rng: np.random.Generator) -> FloatArray:
    """Return what a hand adds to specific force (samples, 3) [g] in a move: it trembles, lifts and sets down.

    ``period`` [s].
    """
    u = np.linspace(0.0, 1.0, samples + 1)
    middle = (u[1:] + u[:-1]) / 2
    held = np.sin(np.pi * middle) ** 2
    t = period * np.arange(samples)
    accel = np.zeros((samples, 3))
    for axis_n in range(3):
        hz, phase = rng.uniform(3, 9, 4), rng.uniform(0, 2 * np.pi, 4)
        accel[:, axis_n] = TREMBLE_G * held * np.sum(np.sin(2 * np.pi * hz * t[:, None] + phase), axis=1)
    for begin in (0.1, 0.75):  # lift, setting down
        within = (middle - begin) / 0.15
        accel[:, 2] += LIFT_G * np.where((within > 0) & (within < 1), np.sin(2 * np.pi * within), 0.0)
    return accel


def shock(
    C_bn: FloatArray, position: int, samples: int, period: float, rng: np.random.Generator, size_g: float
) -> Segment:
    """Return a cube that is bumped or shaken, by random swings of ``size_g`` [g], and does not move."""
    t = period * np.arange(samples)[:, None]
    hz, phase = rng.uniform(3, 20, (2, 4, 3))
    swings = np.sin(2 * np.pi * hz[:, None] * t + phase[:, None]).sum(axis=0)
    return Segment(C_bn, samples, accel_n=size_g / 2 * swings, position=position)


def creep(C_bn: FloatArray, position: int, samples: int, turn_b: FloatArray) -> Segment:
    """Return a cube that turns evenly by the rotation vector ``turn_b`` (3,) [rad], as one that slips does."""
    angle = float(np.linalg.norm(turn_b)) * np.linspace(0.0, 1.0, samples + 1)
    return Segment(C_bn, samples, _unit(turn_b), angle, position=position)


def hand_turn(
    C_bn: FloatArray, axis_b: FloatArray, total: float, rest_samples: int, period: float, rng: np.random.Generator,
    mean_deg_s: float | None = None,
) -> Segment:  # fmt: skip
    """Return a turn by ``total`` [rad] about ``axis_b`` (3,) with a rest before and after it.

    Hand speed is uneven: a raised start and stop and a random sum of slow swings, always forward, about
    ``mean_deg_s`` in the mean, `TURN_RATE_DEG_S` unless it is given.
    """
    seconds = abs(np.degrees(total)) / (mean_deg_s or TURN_RATE_DEG_S) * rng.uniform(0.75, 1.35)
    samples = max(2, int(np.ceil(seconds / period)))
    u = np.linspace(0.0, 1.0, samples + 1)
    order = np.arange(1, 13)
    swing = rng.uniform(-1, 1, 12) / np.sqrt(order)
    speed = np.exp(0.35 * np.sum(swing * np.sin(np.pi * order * u[:, None] + rng.uniform(0, 6.28, 12)), axis=1))
    speed *= np.clip(np.minimum(u, 1 - u) * seconds / 1.5, 0.0, 1.0)  # 1.5 s to speed up and to slow down
    travel = np.concatenate(([0.0], np.cumsum(speed[1:] + speed[:-1])))
    angle = total * np.concatenate((np.zeros(rest_samples), travel / travel[-1], np.ones(rest_samples)))
    return Segment(C_bn, len(angle) - 1, axis_b, angle)


def _unit(vector: FloatArray) -> FloatArray:
    unit: FloatArray = vector / np.linalg.norm(vector)
    return unit


def axis_angle(R: FloatArray) -> tuple[FloatArray, float]:
    """Return the axis (3,) and the angle [rad], 0 to pi, of a rotation ``R`` (3, 3)."""
    # eigenvector of R + R^T for 1: well conditioned at 180 deg too, unlike the skew part
    skew = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = float(np.arctan2(np.linalg.norm(skew), np.trace(R) - 1))
    if angle < 1.0:
        return (_unit(skew), angle) if angle > 0 else (np.array([0.0, 0.0, 1.0]), 0.0)
    axis = np.linalg.eigh((R + R.T) / 2)[1][:, -1]
    return (axis if axis @ skew >= 0 else -axis), angle

"""How the cube moves: rests, flips and manual rotations, as rotations about an axis fixed in the cube.

Attitudes ``C_bn`` (3, 3) take East-North-Up to the cube, ``target_C_bn`` (3, 3) is the last one of a move. The
increments a gyro integrates are differences of a `Segment`'s angle, so a closed turn integrates exactly; vectors
fixed in n are averaged over each sample. The lever arm from the axis is zero.

A `HeldSegment` is carried by hands that tremble about all axes by 20 to 60 deg/s at 2 to 8 Hz, which cones.
"""

from dataclasses import dataclass, field

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation, rotation_vector

SETTLED_TAUS = 12.0  # a settling is cut where it is 6e-6 of its amplitude
TURN_RATE_DEG_S = 35.0  # mean speed of a hand turn
LIFT_G = 0.03  # peak acceleration of the lift
TREMBLE_G = 0.003  # what a hand adds while it holds the cube


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A stretch of motion of ``samples`` samples, or open-ended if None (then at rest).

    ``C_bn`` (3, 3) is the attitude at its start; ``angle`` (samples + 1,) [rad] about ``axis_b`` (3,) at the
    edges of the samples, None at rest; ``accel_n`` (samples, 3) [g] added to gravity's specific force.
    ``position`` is where the cube is reported to rest, 0 while moved; ``rested`` the samples since it came to
    rest.
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


def manual_rotation(
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


FINE_HZ = 2400.0  # of the steps in which the attitude is followed
TREMOR_HZ = (2.0, 8.0)
TREMOR_LINES = 3  # frequencies about each axis
MOVING = (0.1, 0.9)  # of a move's time, between grip and letting go


@dataclass(frozen=True, slots=True, eq=False)
class HeldSegment(Segment):
    """A move whose axis is not fixed: of each sample its mean attitude and its rate.

    ``means`` (samples, 3, 3) [rotation] and ``rates`` (samples, 3) [rad/s];
    ``target`` (3, 3) is the attitude at its end.
    """

    means: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    rates: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    target: FloatArray = field(default_factory=lambda: np.eye(3))

    def end_C_bn(self) -> FloatArray:
        """Return the attitude (3, 3) at the segment's end."""
        return self.target

    def seen(self, vector_n: FloatArray, first: int, last: int) -> FloatArray:
        """Return ``vector_n`` (3,) or (samples, 3) as seen in the cube, mean over samples: (n, 3)."""
        each = vector_n[first:last] if vector_n.ndim == 2 else np.broadcast_to(vector_n, (last - first, 3))
        seen: FloatArray = np.einsum("sbn,sn->sb", self.means[first:last], each)
        return seen

    def rate_b(self, first: int, last: int, period: float) -> FloatArray:
        """Return the mean rate (n, 3) [rad/s] of b relative to n over each sample, resolved in b."""
        return self.rates[first:last]


def carry(
    C_bn: FloatArray, target: FloatArray, samples: int, period: float, rng: np.random.Generator,
    tremor_deg_s: float, pause_s: float = 0.0,
) -> HeldSegment:  # fmt: skip
    """Return a move from ``C_bn`` to ``target``, both (3, 3), in ``samples`` of ``period`` [s], pause included.

    ``tremor_deg_s`` [deg/s] is the tremor's amplitude; in the middle the hand stops for ``pause_s`` [s].
    """
    parts = max(int(np.ceil(FINE_HZ * period)), 1)
    t = np.arange(samples * parts + 1) * period / parts
    attitudes = _attitudes(C_bn, target, t, rng, tremor_deg_s, pause_s)
    steps = -rotation_vector(attitudes[1:] @ np.swapaxes(attitudes[:-1], 1, 2))
    # what a gyroscope integrates is not the rotation vector: less what even these steps cone
    turned = steps - np.cross(np.vstack((steps[:1], steps[:-1])), steps) / 12
    rates = turned.reshape(samples, parts, 3).sum(axis=1) / period
    middle = (attitudes[1:] + attitudes[:-1]) / 2
    means = middle.reshape(samples, parts, 3, 3).mean(axis=1)
    forces = hand_forces(samples, period, rng)
    return HeldSegment(C_bn, samples, accel_n=forces, means=means, rates=rates, target=target)


def _attitudes(
    C_bn: FloatArray, target: FloatArray, t: FloatArray, rng: np.random.Generator, tremor_deg_s: float,
    pause_s: float,
) -> FloatArray:  # fmt: skip
    """Return the cube's attitudes (n, 3, 3) at times (n,) [s]."""
    axis, full = axis_angle(C_bn @ target.T)
    if full > np.pi - 0.02 and rng.random() < 0.5:  # rad: the other way round is as short
        full -= 2 * np.pi
    moving = t[-1] - pause_s
    own = np.where(t < moving / 2, t, np.maximum(t - pause_s, moving / 2)) / moving
    s = np.clip((own - MOVING[0]) / (MOVING[1] - MOVING[0]), 0.0, 1.0)
    smooth = s**3 * (10 - 15 * s + 6 * s**2)
    held = np.sin(np.pi * np.clip(t / t[-1], 0.0, 1.0)) ** 2
    tremor = np.zeros((len(t), 3))
    for about in range(3):
        for hz in rng.uniform(*TREMOR_HZ, TREMOR_LINES):
            size = np.radians(tremor_deg_s) / TREMOR_LINES / (2 * np.pi * hz)
            tremor[:, about] += size * np.sin(2 * np.pi * hz * t + rng.uniform(0, 2 * np.pi))
    attitudes: FloatArray = rotation(-tremor * held[:, None]) @ rotation(-full * smooth[:, None] * axis) @ C_bn
    return attitudes

"""A cube carried by real hands: it trembles about all axes while it is turned, and may stop in the air.

A hand that holds a weight trembles by 20 to 60 deg/s at 2 to 8 Hz, which cones. The gyroscopes integrate the
body's rate over fine steps; gravity and the Earth's rate are averaged over them. ``C_bn`` (3, 3) takes
East-North-Up to the cube.
"""

from dataclasses import dataclass, field

import numpy as np

from drivers.simulated.cube_motion import Segment, axis_angle, hand_forces
from procedures.arrays import FloatArray
from procedures.frames import rotation, rotation_vector

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

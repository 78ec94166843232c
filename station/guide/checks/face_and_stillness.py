"""The two gates: does the right face point up, and is the cube still; from raw counts, second by second.

How far the cube is off the vertical is known as well as the biases of the level accelerometers. Nothing is known
of them at first, so `ALLOWANCE_DEG` is kept back from the limit; two opposite faces show them. Stored parameters
are never used: they may be another unit's, or wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.positions import FACES, face_normal
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK, Block, Stillness

LIMIT_DEG = 3.0
ALLOWANCE_DEG = 0.5  # biases of 8.7 mg
LEARNT_ALLOWANCE_DEG = 0.1
CALM_SHARE = 0.5  # of the limit, in amplitude
CALM_COUNTING_VARIANCE = 0.5  # count^2, twice what counting alone may vary by
TURNING_RATE_RATIO = 3.0  # times the rate at rest, which is the Earth's and the biases
TURNING_COUNTS = 20.0  # times the noise of a second
CHANNEL_NAMES = ("gyro x", "gyro y", "gyro z", "accelerometer x", "accelerometer y", "accelerometer z")


@dataclass(frozen=True, slots=True, eq=False)
class BlockLook:
    """What a block shows: the face that is up, its angle off the vertical, and how still it is (limit 1).

    ``is_calm``: twice as still as it need be, as a cube is that nobody touches. ``sigma`` (6,) [count/s] is what
    the unit's noise makes of a block's rate.
    """

    face: str
    off_deg: float
    still: float
    channel: str
    is_upright: bool
    is_still: bool
    is_calm: bool
    sigma: FloatArray
    hindrance: str


class FaceAndStillnessGate:
    """Judges blocks of one unit in its cube; ``C_sb`` (3, 3) takes the cube's axes to the IMU's."""

    def __init__(self, C_sb: FloatArray) -> None:
        self._C_sb = C_sb
        self.stillness = Stillness()
        self._rest: FloatArray | None = None  # (3,) count/s, the greatest the gyros showed at rest
        self._bias, self._allowance = np.zeros(3), ALLOWANCE_DEG

    @property
    def limit_deg(self) -> float:
        """The angle off the vertical up to which a face counts as resting on the slab."""
        return LIMIT_DEG - self._allowance

    def learn_rest(self, gyro: FloatArray) -> None:
        """Take the gyros' count rates of an accepted rest, ``gyro`` (3,) [count/s]."""
        rest = np.abs(gyro)
        self._rest = rest if self._rest is None else np.maximum(self._rest, rest)

    def learn_faces(self, accel: Mapping[str, FloatArray]) -> None:
        """Take by face the accelerometers' count rates recorded so far, ``accel`` (3,) [count/s], IMU axes."""
        pairs = [(accel[up], accel[down]) for up, down in opposite_faces() if {up, down} <= accel.keys()]
        if pairs:
            self._bias = np.mean([(up + down) / 2 for up, down in pairs], axis=0)
            self._allowance = LEARNT_ALLOWANCE_DEG

    def look(self, block: Block) -> BlockLook:
        """Judge a block."""
        face, off = self.seen_face(block.rate[3:])
        ratio = np.sqrt(block.variance / self.stillness.limit)
        worst = int(np.argmax(ratio))
        is_upright = off <= self.limit_deg
        is_still = self.stillness.is_still(block) and not self._is_turning(block)
        hindrance = ""
        if not block.is_healthy:
            hindrance = "the device reports a fault"
        elif not self.stillness.is_known:
            hindrance = "measuring the noise"
        elif not is_still:
            hindrance = f"waiting for stillness: {CHANNEL_NAMES[worst]} moves"
        elif not is_upright:
            hindrance = f"tilted by {off:.1f} deg, limit {self.limit_deg:.1f} deg"
        calm = np.maximum(CALM_SHARE**2 * self.stillness.limit, CALM_COUNTING_VARIANCE)
        is_calm = is_still and bool(np.all(block.variance <= calm))
        sigma = np.sqrt(np.maximum(self.stillness.noise, MIN_VARIANCE) * TICKS_PER_BLOCK)
        return BlockLook(
            face, off, float(ratio[worst]), CHANNEL_NAMES[worst], is_upright, is_still, is_calm, sigma, hindrance
        )

    def seen_face(self, accel: FloatArray) -> tuple[str, float]:
        """Return the face that is up and its tilt [deg], from count rates ``accel`` (3,), IMU axes."""
        in_cube = self._C_sb.T @ (accel - self._bias)
        face = max(FACES, key=lambda name: float(face_normal(name) @ in_cube))
        upright = float(face_normal(face) @ in_cube)
        level = float(np.linalg.norm(in_cube - upright * face_normal(face)))
        return face, float(np.degrees(np.arctan2(level, upright)))

    def way_up(self, accel: FloatArray) -> FloatArray:
        """Return the unit vector (3,), cube axes, that points up, from count rates ``accel`` (3,), IMU axes.

        It is z for dead accelerometers, until they are detected.
        """
        in_cube = self._C_sb.T @ (accel - self._bias)
        size = float(np.linalg.norm(in_cube))
        up: FloatArray = in_cube / size if size > 0 else np.array([0.0, 0.0, 1.0])
        return up

    def _is_turning(self, block: Block) -> bool:
        """Say whether a gyro shows far more than it did at rest: an even rotation makes nothing tremble."""
        if self._rest is None:
            return False
        sigma = np.sqrt(np.maximum(self.stillness.noise[:3], MIN_VARIANCE) * TICKS_PER_BLOCK)
        return bool(
            np.any(np.abs(block.rate[:3]) > TURNING_RATE_RATIO * self._rest.max() + TURNING_COUNTS * sigma)
        )


def opposite_faces() -> Sequence[tuple[str, str]]:
    """Return the three pairs of faces."""
    return [(up, down) for up, down in pairwise(FACES) if up[0] == down[0]]

"""One attempt at a dwell: seconds are accepted one by one, a knock costs the disturbed ones only.

A cube that was knocked stands where it stood; a cube that was moved does not, and its dwell begins again. What
tells them apart is the rotation that the gyros saw while it was disturbed, whole seconds from rest to rest: it is
zero for a knock. A cube that creeps is still every second: its level accelerometers give it away in the end.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from station.benches.spans import merged
from station.benches.stillness import LEAST, TICKS, Block
from station.guide.judge import Look
from station.recorder.tape import Run

MOVED_DEG = 0.05
CALM_BLOCKS = 1  # still ones after a disturbance that are not used
FEW_BLOCKS = 3
TURNING_SIGMA = 20.0
SECTIONS = 10
CREEP_SIGMA = 7.0  # of nine successive differences
CREEP_RAD = 1e-4  # 20 arcsec: below it the biases of a good unit may wander as well


class Dwelling:
    """Collects ``samples`` samples of ``period`` [s].

    ``gyro_k`` returns the gyros' scale factor [count/rad], roughly, for their count rate (3,) at rest.
    """

    def __init__(self, samples: int, period: float, gyro_k: Callable[[FloatArray], float]) -> None:
        self._wanted, self._period, self._k = samples, period, gyro_k
        self.kept: list[Block] = []
        self._away: list[Block] = []  # since it was last at rest
        self._calm = 0

    @property
    def accepted_s(self) -> float:
        """Accepted seconds, at most those wanted."""
        return min(_samples(self.kept), self._wanted) * self._period

    @property
    def is_complete(self) -> bool:
        """Whether enough was accepted."""
        return _samples(self.kept) >= self._wanted

    @property
    def is_disturbed(self) -> bool:
        """Whether seconds are being left out."""
        return bool(self._away)

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return self.kept[0].first if self.kept else None

    def runs(self) -> list[Run]:
        """Return the accepted samples, as many as wanted."""
        return merged(self.kept, self._wanted)

    def rate(self) -> FloatArray:
        """Return the mean count rate (6,) of what was accepted."""
        rate: FloatArray = np.mean([block.rate for block in self.kept], axis=0)
        return rate

    def take(self, block: Block, look: Look) -> str:
        """Take a block; return why the dwell must begin again, empty if it need not."""
        is_calm = not look.hindrance and not self._is_turning(block)
        if is_calm and not self._away:
            self.kept.append(block)
            return ""
        self._away.append(block)
        if not look.is_upright:
            return f"the cube was lifted or tilted, by {look.off_deg:.0f} deg"
        self._calm = self._calm + 1 if is_calm else 0
        if self._calm <= CALM_BLOCKS:
            return ""
        reason = self._moved()
        self._away, self._calm = [], 0
        if not reason:
            self.kept.append(block)
        return reason

    def forget_restless(self, is_still: Sequence[bool]) -> None:
        """Drop the blocks that are not still by the noise as it is known now."""
        self.kept = [block for block, still in zip(self.kept, is_still, strict=True) if still]

    def crept(self, g_counts: float, level: FloatArray) -> str:
        """Say how far the cube crept, empty if it did not.

        ``g_counts`` is what 1 g counts per second; ``level`` (2, 3) the level axes in the IMU's frame.
        """
        if len(self.kept) < 2 * SECTIONS:
            return ""
        sections = [np.mean([b.rate[3:] for b in part], axis=0) for part in _split(self.kept)]
        tilt = np.array(sections) @ level.T / g_counts
        wander = np.sqrt(np.mean(np.diff(tilt, axis=0) ** 2, axis=0) / 2)
        half = SECTIONS // 2
        crept = np.abs(tilt[half:].mean(axis=0) - tilt[:half].mean(axis=0))
        if np.any((crept > CREEP_RAD) & (crept > CREEP_SIGMA * wander * np.sqrt(2 / half))):
            return f"the cube crept by {np.degrees(2 * crept.max()) * 3600:.0f} arcsec"
        return ""

    def _is_turning(self, block: Block) -> bool:
        """Say whether a gyro is far off its mean so far: an even rotation makes nothing tremble."""
        if len(self.kept) < FEW_BLOCKS:
            return False
        sigma = np.sqrt(np.maximum(block.variance[:3], LEAST) * TICKS)
        return bool(np.any(np.abs(block.rate[:3] - self.rate()[:3]) > TURNING_SIGMA * sigma))

    def _moved(self) -> str:
        """Say by how much the cube was turned while it was disturbed."""
        away = self._away
        if not self.kept:
            return ""
        if any(a.last != b.first or b.is_broken for a, b in pairwise([self.kept[-1], *away])):
            return "samples were lost while it was disturbed"
        rest = self.rate()[:3]
        k = self._k(rest)
        counts = np.sum([(b.rate[:3] - rest) * (b.last - b.first) * self._period for b in away], axis=0)
        sigma = np.sqrt(max(float(np.max([b.variance[:3].max() for b in self.kept])), LEAST) * TICKS * len(away))
        angle = float(np.degrees(np.linalg.norm(counts) / k))
        if angle > MOVED_DEG + np.degrees(5 * sigma / k):
            return f"the cube was moved by {angle:.2f} deg"
        return ""


def level_axes(C_ib: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the two level axes (2, 3) in the IMU's frame of a cube whose ``normal`` (3,) points up."""
    axes = np.eye(3)[np.abs(normal) < 0.5]
    level: FloatArray = axes @ C_ib.T
    return level


def _samples(blocks: Sequence[Block]) -> int:
    return sum(block.last - block.first for block in blocks)


def _split(blocks: Sequence[Block]) -> list[Sequence[Block]]:
    size = len(blocks) // SECTIONS
    return [blocks[i * size : (i + 1) * size] for i in range(SECTIONS)]

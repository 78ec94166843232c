"""One attempt at a dwell: if the bench is bumped, only the affected seconds are discarded.

The rotation that the gyroscopes measure from rest to rest distinguishes a shock, where it is zero, from a cube
that was moved: its dwell starts again. A cube that creeps is detected at the end, by the level accelerometers.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.count_rate import RateEstimate
from procedures.units import ARCSEC_PER_DEG
from station.guide.checks.face_and_stillness import BlockLook
from station.stream.live.stillness import Block, runs_of_blocks
from station.stream.recorder.sample_buffer import SampleRun

TOUCHED = "touched just after placement"
POSITION_CHANGED = "the cube has changed its position since the start of the dwell"
CHANGED_BLOCKS = 5  # still ones in a row, away from what was kept: then what was kept was not at rest
MOVED_DEG = 0.05
CALM_BLOCKS = 1  # still ones after a disturbance that are not used
FEW_BLOCKS = 3
RECENT_BLOCKS = 20  # while rates drift
OFF_SIGMA = 6.0
EARLY_BLOCKS = 5  # a cube that is disturbed as early as this was not let go yet
CREEP_CHI2 = 20.0  # of two level axes: chance passes it once in 20000 dwells
CREEP_RAD = 1e-4  # 20 arcsec: below it the biases of a good unit may drift as much


class DwellAttempt:
    """Collects ``samples`` samples of ``period`` [s].

    ``gyro_k`` returns the gyros' scale factor [count/rad], roughly, for their count rate (3,) at rest.
    ``drifts``: the rates move on purpose, as in a soak, and what is usual is what they were just before.
    """

    def __init__(
        self, samples: int, period: float, gyro_k: Callable[[FloatArray], float], *, drifts: bool = False
    ) -> None:
        self._wanted, self._period, self._k, self._drifts = samples, period, gyro_k, drifts
        self.kept: list[Block] = []
        self._newest: list[Block] = []  # still, and not followed by a still one yet
        self._disturbed: list[Block] = []  # since it was last at rest
        self._calm = 0
        self.is_turned = False  # while it was disturbed
        self._changed = 0  # still blocks in a row that are off what was kept
        self._sigma: FloatArray = np.full(6, np.inf)

    @property
    def accepted_s(self) -> float:
        """Accepted seconds, at most those wanted."""
        return min(_samples(self.kept), self._wanted) * self._period

    @property
    def is_complete(self) -> bool:
        """Whether enough was accepted."""
        return _samples(self.kept) >= self._wanted

    def stop_early(self) -> None:
        """Take it that what was accepted is enough."""
        self._wanted = min(self._wanted, _samples(self.kept))

    @property
    def is_disturbed(self) -> bool:
        """Whether seconds are being discarded."""
        return bool(self._disturbed)

    @property
    def is_early(self) -> bool:
        """Whether so little was accepted that the operator had not let go yet."""
        return len(self.kept) < EARLY_BLOCKS

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return next((block.first for block in (*self.kept, *self._newest, *self._disturbed)), None)

    def runs(self) -> list[SampleRun]:
        """Return the accepted samples, as many as wanted."""
        return runs_of_blocks(self.kept, self._wanted)

    def rate(self) -> FloatArray:
        """Return the mean count rate (6,) of what was accepted."""
        rate: FloatArray = np.mean([block.rate for block in self.kept], axis=0)
        return rate

    def take(self, block: Block, look: BlockLook) -> str:
        """Take a block; return why the dwell must begin again, empty if it need not.

        A block counts once the next one is still as well: a disturbance may have started in it.
        """
        is_off = self._is_off(block, look)
        is_calm = not look.hindrance and not is_off
        self._changed = self._changed + 1 if is_off and not look.hindrance else 0
        if self._changed >= CHANGED_BLOCKS:
            return POSITION_CHANGED
        self._sigma = look.sigma
        if is_calm and not self._disturbed:
            self.kept += self._newest
            self._newest = [block]
            return ""
        self._disturbed += [*self._newest, block]
        self._newest = []
        if not look.is_upright:
            return f"the cube was lifted or tilted, by {look.off_deg:.0f} deg"
        if look.hindrance == "paused" and self.is_early:
            return ""
        self._calm = self._calm + 1 if is_calm else 0
        if self._calm <= CALM_BLOCKS:
            return ""
        reason = self._moved(look)
        if self.is_early:
            reason = f"{reason} just after placement" if reason else TOUCHED
        self._disturbed, self._calm = [], 0
        self._newest = [] if reason else [block]
        return reason

    def drop_unstill(self, is_still: Callable[[Block], bool]) -> None:
        """Drop the blocks that are not still by the noise as it is known now, or off all the others.

        A cube that is being set down smoothly trembles less than a coarse count shows: the first seconds are
        judged by those that followed.
        """
        self.kept = [block for block in self.kept if is_still(block)]
        if self._drifts or not self.kept:
            return
        usual, limit = np.median([block.rate for block in self.kept], axis=0), OFF_SIGMA * self._sigma
        self.kept = [block for block in self.kept if bool(np.all(np.abs(block.rate - usual) <= limit))]

    def _is_off(self, block: Block, look: BlockLook) -> bool:
        """Say whether a channel is far off its median so far: an even motion makes nothing tremble."""
        if self._drifts or len(self.kept) < FEW_BLOCKS:
            return False
        usual = np.median([each.rate for each in self.kept], axis=0)
        return bool(np.any(np.abs(block.rate - usual) > OFF_SIGMA * look.sigma))

    def _moved(self, look: BlockLook) -> str:
        """Say by how much the cube was turned while it was disturbed."""
        away, before = self._disturbed, self.kept[-RECENT_BLOCKS if self._drifts else 0 :]
        if any(a.last != b.first or b.is_broken for a, b in pairwise([*before[-1:], *away])):
            return "samples were lost while it was disturbed"
        still = [*before, *away[-self._calm :]]
        rest = np.mean([block.rate[:3] for block in still], axis=0)
        k = self._k(rest)
        counts = np.sum([(b.rate[:3] - rest) * (b.last - b.first) * self._period for b in away], axis=0)
        # of the disturbed seconds, and of the rate at rest that is subtracted from each
        noise = float(np.max(look.sigma[:3])) * (len(away) + len(away) ** 2 / len(still)) ** 0.5
        angle = float(np.degrees(np.linalg.norm(counts) / k))
        if angle > MOVED_DEG + np.degrees(5 * noise / k):
            self.is_turned = True
            return f"the cube was moved by {angle:.2f} deg"
        return ""


def crept(found: Sequence[RateEstimate], seconds: float, up: FloatArray) -> str:
    """Say how far the cube crept in a dwell of ``seconds``, empty if it did not.

    ``found`` are the accelerometers' rates with their slopes; ``up`` (3,) is the unit vector that points up, in
    the IMU's axes. The slope along a level direction over what 1 g counts is the rate of a tilt.
    """
    rate, slope, std = (np.array([getattr(one, name) for one in found]) for name in ("rate", "slope", "slope_std"))
    level = np.linalg.svd(up[None])[2][1:]  # (2, 3): the level accelerometers themselves where one is upright
    tilt = seconds / float(rate @ up)
    moved = np.abs(level @ slope * tilt)
    chi2 = float(np.sum((level @ slope) ** 2 / (level**2 @ std**2)))
    if moved.max() > CREEP_RAD and chi2 > CREEP_CHI2:
        return f"the cube moved slowly by {np.degrees(moved.max()) * ARCSEC_PER_DEG:.0f} arcsec"
    return ""


def _samples(blocks: Sequence[Block]) -> int:
    return sum(block.last - block.first for block in blocks)

"""A manual rotation as blocks of a second: rest, motion, rest; and whether it was the one asked for."""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Turn
from procedures.frames import AXES
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK, Block

# relative: gyros of one unit agree to some per cent, one revolution more or less is 33 % off
MAX_SCALE_DIFFERENCE = 0.1
MOTION_SIGMAS = 20.0  # times the noise of a second's counts
MOTION_EARTH_RATES = 3.0  # times what the gyros show at rest
# of the turn's counts on the axis, what another axis may show: they are 0.1 deg to 1 deg off square
MAX_OFF_AXIS = 0.2


class RotationDetector:
    """Follows one attempt at ``step``; ``earlier`` holds the counts per revolution of turns already accepted."""

    def __init__(self, step: Turn, C_sb: FloatArray, period: float, earlier: Sequence[float]) -> None:
        self._step, self._C_sb, self._earlier = step, C_sb, earlier
        self._period = period
        self.rest_blocks = max(2, ceil(step.rest_s))
        self._before: list[Block] = []
        self._moving: list[Block] = []
        self._after: list[Block] = []

    @property
    def first(self) -> Block | None:
        """The oldest block that may still become part of the step."""
        return self._before[0] if self._before else None

    @property
    def is_over(self) -> bool:
        """Whether the cube has moved and rests again long enough."""
        return bool(self._moving) and len(self._after) >= self.rest_blocks

    @property
    def is_moving(self) -> bool:
        """Whether the cube has begun to move."""
        return bool(self._moving)

    @property
    def rested_s(self) -> float:
        """How long it has rested since it last moved [s]."""
        return self._seconds(self._after if self._moving else self._before)

    @property
    def moved_s(self) -> float:
        """How long the cube has been moving [s]."""
        return self._seconds(self._moving)

    @property
    def rest_rate(self) -> FloatArray:
        """The gyros' count rate (3,) at rest before the turn; zero before the first second of it."""
        return self._rest() if self._before else np.zeros(3)

    @property
    def rests(self) -> tuple[list[Block], list[Block]]:
        """The blocks at rest before and after."""
        return self._before, self._after[: self.rest_blocks]

    @property
    def turned_counts(self) -> float:
        """The counts of the vertical gyro since it began to move, signed about the axis, less its rate at rest."""
        return float(self._turned() @ self._up()) if self._moving else 0.0

    @property
    def count_rate(self) -> float:
        """The count rate of the vertical gyro now, less that at rest."""
        if not self._moving or self._after:
            return 0.0
        return float((self._moving[-1].rate[:3] - self._rest()) @ self._up())

    @property
    def counts_per_revolution(self) -> float:
        """The counts of the vertical gyro, less its rate at rest, per revolution."""
        return abs(self.turned_counts) / self._step.revolutions

    def take_as(self, step: Turn) -> None:
        """Take it that ``step`` is being done: the same but for its direction."""
        self._step = step

    def rest(self, block: Block) -> None:
        """Take a still block before the turn."""
        if self._before and (self._before[-1].last != block.first or block.is_broken):
            self._before.clear()
        self._before = [*self._before, block][-self.rest_blocks :]

    def take(self, block: Block, *, is_still: bool) -> None:
        """Take a block once the turn may begin."""
        if not is_still or self._is_turning(block):
            self._moving += [*self._after, block]  # a pause shorter than the rest asked for is part of the turn
            self._after.clear()
        elif self._moving:
            self._after.append(block)
        else:
            self.rest(block)

    def step_blocks(self) -> list[Block]:
        """Return the blocks of the step: rest, motion, rest."""
        return [*self._before, *self._moving, *self._after[: self.rest_blocks]]

    def fault(self) -> str:
        """Return in words why this was not the turn asked for, empty if it was."""
        blocks = self.step_blocks()
        if len(self._before) < 2:
            return "there was no rest before it"
        if any(a.last != b.first or b.is_broken for a, b in pairwise(blocks)):
            return "samples were lost while it turned"
        if not self.is_about_axis:
            return "the cube was tipped, or turned about another axis"
        if (self.turned_counts > 0) != (self._step.direction == "+"):
            sense = "counter-clockwise" if self._step.direction == "+" else "clockwise"
            return f"wrong direction, expected {sense} seen from above"
        usual = float(np.median(self._earlier)) if self._earlier else self.counts_per_revolution
        if abs(self.counts_per_revolution / usual - 1) > MAX_SCALE_DIFFERENCE:
            return (
                f"it was {self.counts_per_revolution / usual * self._step.revolutions:.2f} revolutions, "
                f"by the turns before it, expected {self._step.revolutions}"
            )
        return ""

    @property
    def is_about_axis(self) -> bool:
        """Whether what moved so far was a turn about the axis asked for, and not the cube being tipped."""
        turned, up = self._turned(), self._up()
        along = float(turned @ up)
        return bool(np.linalg.norm(turned - along * up) <= MAX_OFF_AXIS * abs(along))

    def _is_turning(self, block: Block) -> bool:
        """Return whether a gyro's rate is far off the one at rest: a motor turns so evenly that nothing trembles.

        In another heading the Earth's rate is another one, by up to twice of it.
        """
        rest = self._rest()
        sigma = np.sqrt(TICKS_PER_BLOCK * np.maximum(block.variance[:3], MIN_VARIANCE))
        return bool(
            np.any(np.abs(block.rate[:3] - rest) > MOTION_SIGMAS * sigma + MOTION_EARTH_RATES * np.abs(rest).max())
        )

    def _up(self) -> FloatArray:
        up: FloatArray = self._C_sb[:, AXES.index(self._step.axis)]
        return up

    def _turned(self) -> FloatArray:
        """Return the counts (3,) of the gyros while moving, less those of their rate at rest."""
        rest = self._rest()
        spans = [(b.last - b.first) * self._period for b in self._moving]
        total: FloatArray = np.sum(
            [(b.rate[:3] - rest) * s for b, s in zip(self._moving, spans, strict=True)], axis=0
        )
        return total

    def _rest(self) -> FloatArray:
        """Return the gyros' count rate (3,) at rest before the turn."""
        rest: FloatArray = np.mean([b.rate[:3] for b in self._before], axis=0)
        return rest

    def _seconds(self, blocks: Sequence[Block]) -> float:
        return sum(b.last - b.first for b in blocks) * self._period

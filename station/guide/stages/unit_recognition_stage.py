"""Is this the unit that the campaign began with? Asked where the device sends no serial number.

On one face the accelerometers' count rates hold scale factor and bias whichever way the cube points, and the
upright gyroscope's hold its bias and the vertical part of the Earth rate. A unit switched on again repeats them to
`MAX_ACCELEROMETER_CHANGE` and `MAX_GYROSCOPE_CHANGE`; another unit of its model seldom comes as near in all.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES
from station.files.campaign_folder.plan_file import UnitRecord
from station.guide.checks.face_and_stillness import BlockLook
from station.guide.setup_view import Choice
from station.guide.stages.stage import Stage
from station.guide.stages.stage_context import StageContext
from station.guide.view import OperatorQuestion
from station.stream.connected_unit import UnitChanged
from station.stream.live.stillness import MIN_VARIANCE, TICKS_PER_BLOCK, Block

MAX_ACCELEROMETER_CHANGE = 1e-3  # of g: turn-on repeatability of bias and scale factor together
MAX_GYROSCOPE_CHANGE = 0.3  # of the greatest gyro rate at rest
MAX_NOISE_RATIO = 2.0  # ratio of sigmas
MAX_PERIOD_DIFFERENCE = 2e-2  # relative: without device time it was measured for 3 s, by a busy machine to 1 %


def same_unit(before: UnitRecord, rate: FloatArray, noise: FloatArray, period: float) -> tuple[bool, str]:
    """Say whether a unit at rest looks like the one of ``before``, and why, in words: evidence, no proof.

    ``rate`` (6,) [count/s] and ``noise`` (6,), its variances [count^2]; ``period`` [s].
    """
    if abs(period / before.period - 1) > MAX_PERIOD_DIFFERENCE:
        return False, f"it sends every {period:.6g} s, the campaign's unit every {before.period:.6g} s"
    if before.rate is None or before.noise is None:
        return False, "no dwell is recorded yet to compare with"
    other = np.array(before.rate)
    if (here := _face(rate)) != (there := _face(other)):
        why = "as in the campaign's first dwell, to compare"
        return False, f"it rests with {here}; put it down with {there}, {why}"
    now, then = (np.maximum(each, MIN_VARIANCE) for each in (noise, np.array(before.noise)))
    if unlike := _differences(rate, other, now, then):
        return False, f"different from the campaign's first dwell: {', '.join(unlike)}"
    return True, "its rates and noise match the first dwell"


def _face(rate: FloatArray) -> str:
    upright = int(np.argmax(np.abs(rate[3:])))
    return f"IMU {AXES[upright]} {'up' if rate[3 + upright] > 0 else 'down'}"


def _differences(rate: FloatArray, other: FloatArray, noise: FloatArray, other_noise: FloatArray) -> list[str]:
    """Say what differs more than switching off and on explains; all (6,), ``other`` are those of before."""
    upright = int(np.argmax(np.abs(other[3:])))
    shift = (rate - other)[3:] / abs(other[3 + upright])
    moved = np.flatnonzero(np.abs(shift) > MAX_ACCELEROMETER_CHANGE).tolist()
    parts = [f"accelerometer {AXES[i]} by {shift[i] * 1e3:+.1f} mg" for i in moved]
    sigma = np.sqrt(TICKS_PER_BLOCK * (noise + other_noise)[upright])
    if abs(rate[upright] - other[upright]) > MAX_GYROSCOPE_CHANGE * np.abs(other[:3]).max() + 5 * sigma:
        parts.append(f"gyro {AXES[upright]} {rate[upright]:.4g} instead of {other[upright]:.4g} counts/s")
    ratio = np.sqrt(noise / other_noise)
    for i in np.flatnonzero((ratio > MAX_NOISE_RATIO) | (ratio < 1 / MAX_NOISE_RATIO)).tolist():
        triad = "gyro" if i < 3 else "accelerometer"
        parts.append(f"noise of {triad} {AXES[i % 3]} {ratio[i]:.2g} times as large")
    return parts


RECOGNITION_BLOCKS = 10


class UnitRecognitionStage(Stage):
    """Compares ten seconds at rest with the campaign's first dwell, then asks."""

    def __init__(self, context: StageContext, before: UnitRecord, then: Callable[[StageContext], Stage]) -> None:
        super().__init__(context)
        self._before, self._then = before, then
        self._blocks: list[Block] = []
        self._text, self._answer, self._hint = "", "", ""

    def take(self, block: Block, look: BlockLook) -> Stage:
        self._hint = look.hindrance
        if self._answer == "y":
            return self._then(self._context)
        if self._text:
            return self
        self._blocks = [] if look.hindrance else [*self._blocks, block]
        if len(self._blocks) == RECOGNITION_BLOCKS:
            self._compare()
        return self

    def answer(self, key: str) -> None:
        """Take the operator's word; raise `UnitChanged` if it is another unit."""
        if key == "n":
            raise UnitChanged(self._context.feed.address.name, "another unit", self._before.serial)
        self._answer = key

    def interrupted(self) -> Stage:
        return UnitRecognitionStage(self._context, self._before, self._then)

    def shown(self) -> dict[str, Any]:
        line = f"is this {self._before.model} {self._before.serial}?"
        shown = {"stage": "settle", "line": line, "hint": self._hint or "leave the cube at rest"}
        choices = (Choice(key="y", title="yes, it is"), Choice(key="n", title="no, it is another"))
        question = OperatorQuestion(text=f"{line} {self._text}", choices=choices) if self._text else None
        return shown | {"question": question}

    def _compare(self) -> None:
        rate = np.mean([block.rate for block in self._blocks], axis=0)
        context = self._context
        is_alike, why = same_unit(self._before, rate, context.gate.stillness.noise, context.feed.period)
        if not context.bench.asks:
            if not is_alike:
                found = f"a unit that sends no serial number; {why}"
                raise UnitChanged(context.feed.address.name, found, self._before.serial)
            self._answer = "y"
        self._text = f"It sends no serial number; {why}."

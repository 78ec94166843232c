"""Counts to rates [rad/s] and specific forces [m/s2] in body axes: by the calibration, and without it.

Without it is what a driver does: one nominal scale factor for a triad's axes, no misalignment, no bias.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.wire import NominalScale
from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_records import CountBlock, SampleBlock
from procedures.effects.excitation import REFERENCE_C
from procedures.units import STANDARD_GRAVITY
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.correction_inputs import WARMTH, Surroundings, TemperatureFollower

NOMINAL_SCALE_DIGITS = 3  # of a nominal scale factor nobody gave


@dataclass(frozen=True, slots=True, eq=False)
class RatesAndForces:
    """Rates (n, 3) [rad/s] and specific forces (n, 3) [m/s2], in the axes that ``C`` of `Sensors` leads to."""

    rate: FloatArray
    force: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedBlock:
    """A block as the calibration has it; ``unsettled`` (n,) are samples that it cannot undo, and nan.

    ``temperature`` [degC] is that of the last sample; ``not_applied`` says what was not corrected.
    """

    found: RatesAndForces
    temperature: float
    unsettled: BoolArray
    not_applied: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedTick:
    """A block: ends (n,) [s] of the samples' intervals, what they say with and without calibration.

    A sample that the calibration cannot undo is in ``calibrated`` what it is without, for filters that go on.
    """

    t: FloatArray
    calibrated: RatesAndForces
    nominal: RatesAndForces
    temperature: float
    is_healthy: bool
    not_applied: tuple[str, ...]


class Sensors:
    """Reads blocks in order; ``calibration`` is calibration/1 or None, ``nominal`` a maker's scale factors.

    ``period`` [s] is the nominal one; ``counts`` says whether the device counts, or sends rates.
    """

    def __init__(
        self, calibration: Mapping[str, Any] | None, nominal: NominalScale | None, C: FloatArray, period: float,
        *, counts: bool = True,
    ) -> None:  # fmt: skip
        self._model = None if calibration is None else CalibrationModel.of(calibration)
        self._C, self._period, self._counts = C, period, counts
        self._scales = _scales_of(calibration) if calibration is not None else _scales_as_made(nominal)
        self._follower = TemperatureFollower() if self._model is None else self._model.follower()

    def quantum(self, seconds: float) -> float:
        """Return by how much a mean specific force over ``seconds`` steps [m/s2] where the device counts."""
        return float(STANDARD_GRAVITY / (np.abs(self._scales[1]).min() * seconds)) if self._counts else 0.0

    def quanta(self) -> tuple[float, float]:
        """Return a count's worth of angle [rad] and of velocity [m/s], of the coarsest axis."""
        gyro, accel = (np.abs(scale).min() for scale in self._scales)
        return float(np.radians(1.0) / gyro), float(STANDARD_GRAVITY / accel)

    def take(self, block: SampleBlock) -> CalibratedTick:
        """Return what a block says, with and without the calibration."""
        nominal, read = self._nominal(block), self.calibrated(block)
        calibrated = nominal if self._model is None else read.found
        if read.unsettled.any():
            lost = read.unsettled[:, None]
            calibrated = RatesAndForces(
                np.where(lost, nominal.rate, calibrated.rate), np.where(lost, nominal.force, calibrated.force)
            )
        is_healthy = bool(block.healthy.all())
        return CalibratedTick(
            block.device_time, calibrated, nominal, read.temperature, is_healthy, read.not_applied
        )

    def calibrated(self, block: SampleBlock) -> CalibratedBlock:
        """Return what a block says; without a calibration by the maker's scale factors. Instead of `take`."""
        signals = self._follower.take(block.device_time, block.temperature)
        temperature = float(signals[WARMTH][-1]) + REFERENCE_C
        if self._model is None:
            return CalibratedBlock(self._nominal(block), temperature, np.zeros(len(block), dtype=np.bool_), ())
        gyro, accel = (self._rates(block, name) for name in ("gyro", "accel"))
        found = self._model.inputs(accel, gyro, Surroundings(t=block.device_time, signals=signals))
        assert found.f is not None
        assert found.omega is not None
        read = self._body(np.radians(found.omega), found.f * STANDARD_GRAVITY)
        return CalibratedBlock(read, temperature, found.unsettled, found.not_applied)

    def _nominal(self, block: SampleBlock) -> RatesAndForces:
        gyro, accel = (self._rates(block, name) for name in ("gyro", "accel"))
        return self._body(np.radians(gyro / self._scales[0]), accel / self._scales[1] * STANDARD_GRAVITY)

    def _rates(self, block: SampleBlock, name: str) -> FloatArray:
        values: FloatArray = getattr(block, name).astype(np.float64)
        return values / self._period if isinstance(block, CountBlock) else values

    def _body(self, rate: FloatArray, force: FloatArray) -> RatesAndForces:
        return RatesAndForces(rate @ self._C.T, force @ self._C.T)


def _scales_of(calibration: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Return one scale factor for all axes of each triad (3,), signs as they are: the mean to 3 digits."""
    found = list[FloatArray]()
    for name in ("gyroscope", "accelerometer"):
        k = np.array(calibration[name]["scale_factor"]["value"], dtype=np.float64)
        found.append(np.sign(k) * mean_scale(k))
    return found[0], found[1]


def mean_scale(k: FloatArray) -> float:
    """Return the size of scale factors ``k`` (3,), whichever way their axes count: the mean to 3 digits."""
    return float(f"{np.abs(k).mean():.{NOMINAL_SCALE_DIGITS}g}")


def _scales_as_made(nominal: NominalScale | None) -> tuple[FloatArray, FloatArray]:
    if nominal is None:
        raise ValueError("neither a calibration nor a maker's scale factors")
    return np.full(3, np.radians(1.0) / nominal.gyro), np.full(3, STANDARD_GRAVITY / nominal.accel)

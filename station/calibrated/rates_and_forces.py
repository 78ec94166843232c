"""Counts to rates [rad/s] and specific forces [m/s2] in body axes: by the calibration, and without it.

Without it is what a driver does: one nominal scale factor for a triad's axes, no misalignment, no bias.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.wire import NominalScale
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock, SampleBlock
from procedures.units import STANDARD_GRAVITY
from station.calibrated.calibration_applied import Surroundings, calibrated_inputs
from station.calibrated.temperature_memory import TemperatureMemory

NOMINAL_SCALE_DIGITS = 3  # of a nominal scale factor nobody gave
SLOPE_S = 60.0  # over which the temperature's rate is taken
MIN_SLOPE_S = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class RatesAndForces:
    """Rates (n, 3) [rad/s] and specific forces (n, 3) [m/s2], forward-right-down."""

    rate: FloatArray
    force: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedTick:
    """A tenth of a second: ends (n,) [s] of the samples' intervals, what they say with and without calibration."""

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
        self._calibration, self._C, self._period, self._counts = calibration, C, period, counts
        self._scales = _scales_of(calibration) if calibration is not None else _scales_as_made(nominal)
        self._memory = TemperatureMemory(calibration or {"effects": []})
        self._temperatures: deque[tuple[float, float]] = deque()

    def quantum(self, seconds: float) -> float:
        """Return by how much a mean specific force over ``seconds`` steps [m/s2] where the device counts."""
        return float(STANDARD_GRAVITY / (np.abs(self._scales[1]).min() * seconds)) if self._counts else 0.0

    def quanta(self) -> tuple[float, float]:
        """Return a count's worth of angle [rad] and of velocity [m/s], of the coarsest axis."""
        gyro, accel = (np.abs(scale).min() for scale in self._scales)
        return float(np.radians(1.0) / gyro), float(STANDARD_GRAVITY / accel)

    def take(self, block: SampleBlock) -> CalibratedTick:
        """Return what a block says."""
        gyro, accel = (self._rates(block, name) for name in ("gyro", "accel"))
        nominal = self._body(np.radians(gyro / self._scales[0]), accel / self._scales[1] * STANDARD_GRAVITY)
        temperature = self._temperature(block)
        calibrated, left = nominal, tuple[str, ...]()
        if self._calibration is not None:
            n = len(block)
            memory = self._memory
            around = Surroundings(
                np.full(n, temperature), np.full(n, self._slope()), t=block.device_time,
                followed=dict(memory.followed), direction=memory.direction,
            )  # fmt: skip
            memory.advance(float(block.device_time[-1]), temperature)
            found = calibrated_inputs(self._calibration, accel, gyro, around)
            assert found.f is not None
            assert found.omega is not None
            calibrated = self._body(np.radians(found.omega), found.f * STANDARD_GRAVITY)
            left = found.not_applied
        return CalibratedTick(block.device_time, calibrated, nominal, temperature, bool(block.healthy.all()), left)

    def _rates(self, block: SampleBlock, name: str) -> FloatArray:
        values: FloatArray = getattr(block, name).astype(np.float64)
        return values / self._period if isinstance(block, CountBlock) else values

    def _body(self, rate: FloatArray, force: FloatArray) -> RatesAndForces:
        return RatesAndForces(rate @ self._C.T, force @ self._C.T)

    def _temperature(self, block: SampleBlock) -> float:
        """Return the newest temperature that is known [degC], nan if none ever was."""
        known = block.temperature[np.isfinite(block.temperature)]
        seen = self._temperatures
        if len(known):
            now = float(block.device_time[-1])
            if seen and now <= seen[-1][0]:  # the device began anew
                seen.clear()
            if not seen or now - seen[-1][0] >= 1.0:
                seen.append((now, float(known.mean())))
            while now - seen[0][0] > SLOPE_S:
                seen.popleft()
        return seen[-1][1] if seen else float("nan")

    def _slope(self) -> float:
        """Return the temperature's rate [K/min]; nought before it can be told, nan without a temperature."""
        seen = self._temperatures
        if not seen:
            return float("nan")
        seconds = seen[-1][0] - seen[0][0]
        return 60.0 * (seen[-1][1] - seen[0][1]) / seconds if seconds >= MIN_SLOPE_S else 0.0


def _scales_of(calibration: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Return one scale factor for all axes of each triad (3,), signs as they are: the mean to 3 digits."""
    found = list[FloatArray]()
    for name in ("gyroscope", "accelerometer"):
        k = np.array(calibration[name]["scale_factor"]["value"], dtype=np.float64)
        found.append(np.sign(k) * float(f"{np.abs(k).mean():.{NOMINAL_SCALE_DIGITS}g}"))
    return found[0], found[1]


def _scales_as_made(nominal: NominalScale | None) -> tuple[FloatArray, FloatArray]:
    if nominal is None:
        raise ValueError("neither a calibration nor a maker's scale factors")
    return np.full(3, np.radians(1.0) / nominal.gyro), np.full(3, STANDARD_GRAVITY / nominal.accel)

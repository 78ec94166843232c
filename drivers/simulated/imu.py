"""A simulated IMU in its cube, in virtual time: commands queue motion, `SimulatedImu.read` lets time pass.

Equal truths, seeds and commands at equal sample counts give equal counts, however the samples are asked for.
"""

from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from drivers.simulated.bench_in_memory import PoweredUnit, turn_segment
from drivers.simulated.cube_motion import Segment, carry, creep, flip, rest, settle, shock
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack, drive
from procedures.arrays import FloatArray, IntArray
from procedures.campaign.plan_steps import Turn
from procedures.counts.sample_records import CountBlock, RateBlock
from procedures.frames import rotation
from procedures.free_positions.free_attitudes import C_bn_of_up
from procedures.positions import ATTITUDES

Z_UP_POSITION = 9  # the position with z up, as which it is carried
TILT_STD_DEG = 3.0  # how far off a free attitude is set by hand
COUNT_PER_RAD, COUNT_PER_G_S = np.degrees(36000.0), 1000.0  # usual scale factors, see `SimulatedImu.read_rates`
MAX_TREMOR_DEG_S = 500.0
A = TypeVar("A", IntArray, FloatArray)
Sampled = Callable[[Segment, int, int, int], tuple[A, A]]


class SimulatedImu(PoweredUnit):
    """One power-on of a unit resting in position 1; ``truth`` has the turn-on biases in it.

    ``seed`` None: no noise, no scatter of headings and closures. ``index`` is the number of samples taken.
    """

    def __init__(self, truth: Truth, seed: int | None) -> None:
        super().__init__(truth, seed)
        self.index = 0
        self.position = 1
        self._first = 0  # samples taken of the segment under way
        C_bn = self._placed(self.position)
        self._segments = deque([rest(C_bn, None, self.position)])

    @property
    def time(self) -> float:
        """Device time [s] of the last sample taken."""
        return self.index * self.truth.sample_period_s

    @property
    def done(self) -> float:
        """Device time [s] at which all commanded motion will be over."""
        return (self.index + self._queued()) * self.truth.sample_period_s

    @property
    def is_moving(self) -> bool:
        """Whether commanded motion or rest is still under way."""
        return self._queued() > 0

    def place(self, position: int, move_s: float = 45.0, off_b: FloatArray | None = None) -> None:
        """Put the cube into ``position`` 1..24 by hand within ``move_s`` [s]; then it settles and rests.

        ``off_b`` (3,) [rad] is the rotation vector, in the cube's axes, by which it does not stand as it should.
        """
        if position not in range(1, len(ATTITUDES) + 1):
            raise ValueError(f"position {position}: expected 1 to {len(ATTITUDES)}")
        C_bn = self._placed(position)
        if off_b is not None:
            C_bn = rotation(-off_b) @ C_bn
        self._set_down(self._flipped(C_bn, move_s), C_bn, position)

    def carry(self, position: int, move_s: float, tremor_deg_s: float, pause_s: float = 0.0) -> None:
        """Put the cube into ``position`` 1..24 with hands that tremble and stop in the air, see `carry`."""
        if position not in range(1, len(ATTITUDES) + 1):
            raise ValueError(f"position {position}: expected 1 to {len(ATTITUDES)}")
        if not (0 < move_s < 1e4 and 0 <= pause_s < 1e4 and 0 <= tremor_deg_s <= MAX_TREMOR_DEG_S):
            found = f"carry in {move_s} s with {tremor_deg_s} deg/s and a pause of {pause_s} s"
            raise ValueError(f"{found}: expected 0 to 1e4 s and up to {MAX_TREMOR_DEG_S:g} deg/s")
        C_bn, period = self._placed(position), self.truth.sample_period_s
        samples = max(self._samples(move_s + pause_s), 1)
        before = self._segments[-1].C_bn
        self._set_down(carry(before, C_bn, samples, period, self._hands, tremor_deg_s, pause_s), C_bn, position)

    def _flipped(self, C_bn: FloatArray, move_s: float) -> Segment:
        samples, period = self._samples(move_s), self.truth.sample_period_s
        return flip(self._segments[-1].C_bn, C_bn, samples, period, self._hands)

    def _set_down(self, move: Segment, C_bn: FloatArray, position: int) -> None:
        """Let a move end in ``C_bn`` (3, 3), where the cube settles and rests."""
        truth = self.truth
        settling = settle(C_bn, position, truth.sample_period_s, self._hands, self._scatter * truth.settle_rad,
                          truth.settle_tau_s, truth.settle_hz)  # fmt: skip
        self._append(move, settling, rest(C_bn, None, position, settling.samples or 0))
        self.position = position

    def tilt(self, up_b: FloatArray, move_s: float = 45.0) -> None:
        """Prop the cube so that ``up_b`` (3,), its own axes, about points up, as well as hands do it."""
        if not np.isfinite(up_b).all() or not np.linalg.norm(up_b):
            raise ValueError(f"up {up_b}: expected a way that can point up")
        missed = np.radians(TILT_STD_DEG) * self._scatter * self._hands.standard_normal(3)
        heading = self._hands.uniform(0, 2 * np.pi)
        C_bn = rotation(missed) @ C_bn_of_up(up_b, heading)
        self._append(self._flipped(C_bn, move_s), rest(C_bn, None, 0, 0))
        self.position = 0

    def heat(self, kelvin: float, tau_s: float) -> None:
        """Warm the unit by ``kelvin`` from now on (cool it if negative), exponentially in ``tau_s`` [s]."""
        if not abs(kelvin) <= 100 or not 0 < tau_s < 1e6:
            raise ValueError(f"heat by {kelvin} K in {tau_s} s: expected up to 100 K and 0 to 1e6 s")
        self.sensor.heat(self.time, kelvin, tau_s)

    def shock(self, seconds: float, size_g: float) -> None:
        """Knock or shake the cube where it stands."""
        last, samples = self._segments[-1], self._samples(seconds)
        shaken = shock(last.C_bn, self.position, samples, self.truth.sample_period_s, self._hands, size_g)
        self._append(shaken, rest(last.C_bn, None, self.position, samples))

    def creep(self, seconds: float, turn_b: FloatArray) -> None:
        """Let the cube turn evenly by the rotation vector ``turn_b`` (3,) [rad], its own axes."""
        moved = creep(self._segments[-1].C_bn, self.position, self._samples(seconds), turn_b)
        self._append(moved, rest(moved.end_C_bn(), None, self.position))

    def rest(self, seconds: float) -> None:
        """Leave the cube alone for ``seconds`` before the next command acts."""
        last, samples = self._segments[-1], self._samples(seconds)
        rested = (last.rested or 0) + (self._first if len(self._segments) == 1 else 0)
        self._append(
            rest(last.C_bn, samples, last.position, rested), rest(last.C_bn, None, last.position, rested + samples)
        )

    def drive(self, track: VehicleTrack) -> None:
        """Carry the cube along a track, x ahead and z up, from now on; the track's time is the device's."""
        C_bn, first = self.world.attitude(Z_UP_POSITION), self.index + self._queued()
        carried = drive(track, C_bn, first, self.truth.sample_period_s)
        self._append(carried, rest(carried.end_C_bn(), None, 0))
        self.position = 0

    def turn(self, axis: str, direction: str, revolutions: int, rest_s: float = 5.0) -> None:
        """Turn the cube by hand about its vertical ``axis``; at rest for ``rest_s`` before and after.

        Raises `ValueError`: ``axis`` is not vertical where the cube stands, or an argument is not a turn's.
        """
        turn = Turn(axis, direction, revolutions, self.position, rest_s)
        C_bn, period = self._segments[-1].C_bn, self.truth.sample_period_s
        segment = turn_segment(self.world, C_bn, turn, self._closure(), period, self._hands)
        self._append(segment, rest(segment.end_C_bn(), None, self.position, self._samples(rest_s)))

    def read(self, n_samples: int) -> CountBlock:
        """Let ``n_samples`` sample periods pass and return their counts."""
        gyro, accel = self._take(n_samples, self.sensor.counts, np.zeros((0, 3), np.int64))
        return CountBlock(**self._columns(n_samples), gyro=gyro, accel=accel)

    def read_rates(self, n_samples: int) -> RateBlock:
        """Let as much time pass as `read` and return rad/s and g, as a unit of usual scale factors says them.

        A unit's scale factor errors are those of its truth to `COUNT_PER_RAD` and `COUNT_PER_G_S`.
        """
        gyro, accel = self._take(n_samples, self.sensor.rates, np.zeros((0, 3)))
        return RateBlock(**self._columns(n_samples), gyro=gyro / COUNT_PER_RAD, accel=accel / COUNT_PER_G_S)

    def _take(self, n_samples: int, sampled: Sampled[A], none: A) -> tuple[A, A]:
        """Go on by ``n_samples``; return what ``sampled`` gives for them, gyros and accelerometers (n, 3)."""
        parts, missing = [(none, none)], n_samples
        while missing > 0:
            segment = self._segments[0]
            left = missing if segment.samples is None else segment.samples - self._first
            take = min(missing, left)
            if take > 0:
                parts.append(sampled(segment, self.index, self._first, self._first + take))
            self._first, self.index, missing = self._first + take, self.index + take, missing - take
            if segment.samples is not None and self._first == segment.samples:
                self._segments.popleft()
                self._first = 0
        gyro, accel = zip(*parts, strict=True)
        return np.concatenate(gyro), np.concatenate(accel)

    def _columns(self, n_samples: int) -> dict[str, Any]:
        """Return what comes with the values of the last ``n_samples``."""
        counter = np.arange(self.index - n_samples, self.index, dtype=np.int64)
        time: FloatArray = self.truth.sample_period_s * (counter + 1).astype(np.float64)
        return {
            "counter": counter,
            "device_time": time,
            "temperature": self.sensor.temperature(time),
            "status": np.zeros(n_samples, dtype=np.int64),
            "healthy": np.ones(n_samples, dtype=np.bool_),
        }

    def _append(self, *segments: Segment) -> None:
        self._segments.pop()  # the open rest, as long as it has lasted
        if not self._segments:
            self._first = 0
        self._segments.extend(segments)

    def _queued(self) -> int:
        finite = sum(segment.samples or 0 for segment in self._segments)
        return finite - self._first if len(self._segments) > 1 else 0

    def _samples(self, seconds: float) -> int:
        if not 0 <= seconds < 1e6:
            raise ValueError(f"{seconds} s: expected 0 to 1e6")
        return round(seconds / self.truth.sample_period_s)

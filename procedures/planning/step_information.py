"""The information that each step of a design adds to both triads' fits, from the unit's noise."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.bench.dwell_length import REMAINDER_COUNTS, WHITE_NOISE_FACTOR
from procedures.campaign.campaign import Campaign
from procedures.planning.campaign_design import HandTimes, Placement
from procedures.planning.placement_rows import ACCEL, BENCH, OWN, SHARED, PlacementRows, placement_rows
from procedures.twelve_positions.bench_parameters import BenchParameters
from procedures.units import RAD_PER_ARCSEC, RAD_PER_DEG

REMAINDERS_OF_A_DWELL = 2.0  # `REMAINDER_COUNTS` is of a bias: half the root of the sum of four dwells' squares
CONING_RAD = 0.15 * RAD_PER_ARCSEC  # rad, 1 sigma of what coning leaves of a move of hands at 50 Hz


@dataclass(frozen=True, slots=True, eq=False)
class UnitNoise:
    """White noise (3,) of the accelerometers [g sqrt(s)] and gyroscopes [deg/sqrt(s)], and what one count is.

    ``accel_scale`` (3,) [count/(g s)] and ``gyro_scale`` (3,) [count/deg] are infinite where nothing is counted.
    ``instability`` [deg/s] is 1 sigma of the gyroscopes' bias from step to step.
    """

    accel_white: FloatArray
    gyro_white: FloatArray
    accel_scale: FloatArray
    gyro_scale: FloatArray
    instability: float

    def times(self, accel: float, gyro: float) -> "UnitNoise":
        """Return it with white noise that is larger by these factors."""
        return replace(self, accel_white=accel * self.accel_white, gyro_white=gyro * self.gyro_white)

    def accel_variance(self, seconds: FloatArray) -> FloatArray:
        """Return (n, 3) [g2] of the specific force in dwells of ``seconds`` (n,)."""
        return _dwell_variance(self.accel_white, self.accel_scale, seconds)

    def gyro_variance(self, seconds: FloatArray) -> FloatArray:
        """Return (n, 3) [deg2/s2] of the rate in dwells of ``seconds`` (n,), the bias instability in it."""
        return _dwell_variance(self.gyro_white, self.gyro_scale, seconds) + self.instability**2

    def turn_variance(self, seconds: float) -> FloatArray:
        """Return (3,) [deg2] of the total of a turn of ``seconds``; a counter's two remainders have 1/6."""
        return self.gyro_white**2 * seconds + 1 / 6 / self.gyro_scale**2 + (self.instability * seconds) ** 2

    def move_variance(self, seconds: float) -> float:
        """Return [rad2] of each component of a move's rotation: noise, rounding, the bias instability, coning."""
        rounding = 2 / 12 * float(np.mean(1 / self.gyro_scale**2))
        white = float(np.mean(self.gyro_white**2)) * seconds
        return (white + rounding + (self.instability * seconds) ** 2) * RAD_PER_DEG**2 + CONING_RAD**2


def _dwell_variance(white: FloatArray, scale: FloatArray, seconds: FloatArray) -> FloatArray:
    T = np.asarray(seconds)[:, None]
    remainder = REMAINDERS_OF_A_DWELL * REMAINDER_COUNTS / (scale * T)
    return (WHITE_NOISE_FACTOR * white) ** 2 / T + remainder**2


NO_CLOSURE_STD_RAD = 1e-9  # rad, of a dwell, which closes nothing
OWN_FIT = np.r_[ACCEL, BENCH]  # what the accelerometers' own fit has of the shared columns


@dataclass(frozen=True, eq=False)
class StepInformation:
    """What is known of a unit and its bench. ``campaign`` has site, cube and care; its steps are not looked at.

    Columns are those of `procedures.planning.placement_rows`.
    """

    campaign: Campaign
    noise: UnitNoise
    hands: HandTimes = field(default_factory=HandTimes)
    _placed: dict[Placement, FloatArray] = field(default_factory=dict)

    @cached_property
    def rows(self) -> PlacementRows:
        """The rows of everything that can be done."""
        return placement_rows(self.campaign, self.hands)

    def with_noise(self, noise: UnitNoise) -> "StepInformation":
        """Return the same bench with a unit of other noise; its rows are not made again."""
        other = replace(self, noise=noise, _placed={})
        other.__dict__["rows"] = self.rows
        return other

    def placed(self, at: Placement) -> FloatArray:
        """Return what a dwell or a turn adds (43, 43), with what is known of its heading, seat and closure."""
        if at not in self._placed:
            found = self._turned(at.turn) if at.turn is not None else self._rested(at)
            care = self.campaign.sigma
            closure = NO_CLOSURE_STD_RAD if at.turn is None else care.closure
            found[:OWN, :OWN] += np.diag(1 / np.square([care.heading, care.seat, care.seat, closure]))
            self._placed[at] = found
        return self._placed[at]

    def moved(self, before: int, after: int | IntArray) -> FloatArray:
        """Return what moves to positions ``after`` (...) add (..., 47, 47)."""
        found: FloatArray = self._moved[before - 1, after - 1]
        return found

    def moved_back(self, before: int | IntArray, after: int) -> FloatArray:
        """Return the same (..., 47, 47) of positions ``before`` (...), columns of the next placement first."""
        found: FloatArray = self._moved_back[before - 1, after - 1]
        return found

    def information(self, at: Placement) -> FloatArray:
        """Return what a dwell adds (27, 27) to the accelerometers' own fit: columns `OWN_FIT` of the shared."""
        rows = self.rows.accel[at.position - 1][:, OWN:][:, OWN_FIT]
        variance = self.noise.accel_variance(np.array([at.seconds]))[0]
        found: FloatArray = rows.T @ (rows / variance[:, None])
        return found

    def bench(self, *, skew_seen: bool) -> BenchParameters:
        """Return the bench's parameters; moves show a cube's skew."""
        return replace(self.rows.bench, skew_seen=skew_seen)

    def known(self, *, skew_seen: bool) -> FloatArray:
        """Return what is known of the bench before the first count (39, 39)."""
        bench = self.bench(skew_seen=skew_seen)
        rows = bench.priors().matrix[:, : bench.shared]
        found = np.zeros((SHARED, SHARED))
        found[BENCH, BENCH] = rows.T @ rows
        return found

    def _rested(self, at: Placement) -> FloatArray:
        accel, gyro = self.rows.accel[at.position - 1], self.rows.gyro[at.position - 1]
        seconds = np.array([at.seconds])
        found: FloatArray = accel.T @ (accel / self.noise.accel_variance(seconds).T)
        found += gyro.T @ (gyro / self.noise.gyro_variance(seconds).T)
        return found

    def _turned(self, turn: int) -> FloatArray:
        rows = self.rows.turn[turn]
        found: FloatArray = rows.T @ (rows / self.noise.turn_variance(self.hands.turn)[:, None])
        return found

    @cached_property
    def _moved(self) -> FloatArray:
        rows = self.rows.move
        return np.swapaxes(rows, 2, 3) @ rows / self.noise.move_variance(self.hands.move)

    @cached_property
    def _moved_back(self) -> FloatArray:
        order = np.r_[OWN : 2 * OWN, :OWN, 2 * OWN : 2 * OWN + SHARED]
        return self._moved[..., order[:, None], order]

"""What every step of a design adds to the normal matrices of both triads' fits, by the unit's noise."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign
from procedures.dwells_and_turns.bench_parameters import BenchParameters
from procedures.planning.campaign_design import HandTimes, Placing
from procedures.planning.placing_rows import ACCEL, BENCH, OWN, SEAT, SHARED, PlacingRows, placing_rows
from procedures.planning.unit_noise import UnitNoise

NO_CLOSURE_STD_RAD = 1e-9  # rad, of a dwell, which closes nothing
TOLD = np.r_[ACCEL, BENCH]  # what the accelerometers' own fit has of the shared columns


@dataclass(frozen=True, eq=False)
class StepInformation:
    """What is known of a unit and its bench. ``campaign`` has site, cube and care; its steps are not looked at.

    Columns are those of `procedures.planning.placing_rows`.
    """

    campaign: Campaign
    noise: UnitNoise
    hands: HandTimes = field(default_factory=HandTimes)
    _known: dict[tuple[Placing, bool], FloatArray] = field(default_factory=dict)

    @cached_property
    def rows(self) -> PlacingRows:
        """The rows of everything that can be done."""
        return placing_rows(self.campaign, self.hands)

    def with_noise(self, noise: UnitNoise) -> "StepInformation":
        """Return the same bench with a unit of other noise; its rows are not made again."""
        other = replace(self, noise=noise, _known={})
        other.__dict__["rows"] = self.rows
        return other

    def placed(self, at: Placing, moves: bool) -> FloatArray:
        """Return what a dwell or a turn adds (43, 43), with what is known of its heading, seat and closure.

        Without ``moves`` no seats are fitted.
        """
        if (at, moves) not in self._known:
            found = self._turned(at.turn, moves) if at.turn is not None else self._rested(at, moves)
            care = self.campaign.sigma
            closure = NO_CLOSURE_STD_RAD if at.turn is None else care.closure
            found[:OWN, :OWN] += np.diag(1 / np.square([care.heading, care.seat, care.seat, closure]))
            self._known[at, moves] = found
        return self._known[at, moves]

    def moved(self, before: int, after: int | IntArray, moves: bool = True) -> FloatArray:
        """Return what moves to positions ``after`` (...) add (..., 47, 47), nothing without ``moves``."""
        found: FloatArray = self._moved[before - 1, after - 1] * moves
        return found

    def moved_back(self, before: int | IntArray, after: int) -> FloatArray:
        """Return the same (..., 47, 47) of positions ``before`` (...), the columns of the placing after first."""
        found: FloatArray = self._moved_back[before - 1, after - 1]
        return found

    def told(self, at: Placing) -> FloatArray:
        """Return what a dwell adds (27, 27) to the accelerometers' own fit: columns `TOLD` of the shared."""
        rows = self.rows.accel[at.position - 1][:, OWN:][:, TOLD]
        variance = self.noise.accel_variance(np.array([at.seconds]))[0]
        found: FloatArray = rows.T @ (rows / variance[:, None])
        return found

    def bench(self, moves: bool) -> BenchParameters:
        """Return the bench's parameters; with ``moves`` a cube's skew is seen."""
        return replace(self.rows.bench, skew_seen=moves)

    def known(self, moves: bool) -> FloatArray:
        """Return what is known of the bench before the first count (39, 39)."""
        bench = self.bench(moves)
        rows = bench.priors().matrix[:, : bench.shared]
        found = np.zeros((SHARED, SHARED))
        found[BENCH, BENCH] = rows.T @ rows
        return found

    def _rested(self, at: Placing, moves: bool) -> FloatArray:
        accel = self.rows.accel[at.position - 1].copy()
        accel[:, SEAT] *= moves
        gyro, seconds = self.rows.gyro[at.position - 1], np.array([at.seconds])
        found: FloatArray = accel.T @ (accel / self.noise.accel_variance(seconds).T)
        found += gyro.T @ (gyro / self.noise.gyro_variance(seconds).T)
        return found

    def _turned(self, turn: int, moves: bool) -> FloatArray:
        rows = self.rows.turn[turn].copy()
        rows[:, SEAT] *= moves
        found: FloatArray = rows.T @ (rows / self.noise.turn_variance(self.hands.turn)[:, None])
        return found

    @cached_property
    def _moved(self) -> FloatArray:
        rows = self.rows.move
        found: FloatArray = np.swapaxes(rows, 2, 3) @ rows / self.noise.move_variance(self.hands.move)
        return found

    @cached_property
    def _moved_back(self) -> FloatArray:
        order = np.r_[OWN : 2 * OWN, :OWN, 2 * OWN : 2 * OWN + SHARED]
        return self._moved[..., order[:, None], order]

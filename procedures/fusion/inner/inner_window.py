"""Han's inner layer: the last keyframes, tied by the IMU and held by GNSS, fitted together as each one comes.

Preintegration, the biases' walks, GNSS and what a prior knows of keyframes that have left are one least squares
problem (Han 2022 IV.A). What leaves is marginalised with all that was seen of it. Over a gap of the IMU a straight
line is integrated, with as much noise as such a line misses.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.gnss_velocity import (
    CLIMB_SPAN_S,
    GnssMeasurements,
    KeyframeFix,
    LeverArm,
    measurements,
    no_fix,
)
from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.wheel_aid import RETRACTED_S, WheelAid, predicted_covariance, without_wheel
from procedures.fusion.inner.window_problem import (
    BackSubstitution,
    Prior,
    WindowMeasurements,
    assemble,
    marginalised,
)
from procedures.fusion.inner.window_state import COMMON, FRAME, WHEEL, ChainFactor, Factor, WindowState
from procedures.fusion.inner.window_terms import Site, predicted
from procedures.fusion.pose_graph_terms import rz
from procedures.fusion.preintegration import ImuGap, ImuGrid, Preintegrated, grid, imu_gaps, preintegrate

STEP_TOLERANCE = 2e-2  # of a sigma, by which a last step may move
OUTAGE_S = 1.5  # s without a velocity from which an outage begins
FRAME_STD = np.radians(0.05)  # rad: GNSS's velocities hold the odometry's frame to n
FRAME_WALK = 1e-4  # rad/sqrt(s)
ORIGIN_STD = 1e-3  # m, the origin of an odometry
FREE_VELOCITY = 1.0  # m/s
KNOWN_STD = 1e-6  # m, rad or s, of what is not estimated


class InnerWindow:
    """Keyframes at ``times`` (n,) [s] of a recording, and then those that `_live` lays behind them.

    The window is ``frames`` long and fitted in at most ``rounds``; the noise of ``site`` is shaken.
    """

    def __init__(
        self, site: Site, frames: int, rounds: int, times: FloatArray, imu: ImuSeries, fixes: GnssFixes,
        start: AlignmentState, begun: tuple[WindowState, Prior], antenna: LeverArm, wheel: WheelAid | None = None,
    ) -> None:  # fmt: skip
        self._site, self._frames, self._rounds = site, frames, rounds
        self.fixes, self.start, self.antenna = fixes, start, antenna
        self.wheel, self._imu = wheel, imu
        self.marks, self._scale = Landmarks(), np.ones(2)
        self.state, self._prior = begun
        self._grid, self._gaps = grid(imu, times), imu_gaps(imu)
        self._measured = self._measurements(fixes, imu)
        self._held = WindowMeasurements([], [no_fix()])
        self.awaited = 0  # keyframes that it is longer by, as many as wait for what a late source will say of them
        self.t, self._since = float(times[0]), 0.0  # of the newest keyframe; s without a velocity

    @property
    def velocity(self) -> FloatArray:
        """The newest keyframe's velocity (3,) [m/s] in n."""
        v: FloatArray = self._heading() @ self.state.v[-1]
        return v

    def covariance(self, at: slice) -> FloatArray:
        """Return the covariance (k, k) of k numbers of the state, in their units."""
        return self._factor.covariance(at)

    @property
    def last(self) -> int:
        """Where the newest keyframe begins in the state."""
        return COMMON + FRAME * (len(self.state.p) - 1)

    def _measurements(self, fixes: GnssFixes, imu: ImuSeries) -> GnssMeasurements:
        return measurements(fixes, imu)

    def _recorded(self, k: int) -> Preintegrated | None:
        """Return the IMU from keyframe k - 1 to k of the recording, None for the first."""
        return self._integrated(self._grid, slice(*self._grid.at[k - 1 : k + 1].tolist())) if k else None

    def _live(self, t: float, imu: ImuSeries, fixes: GnssFixes) -> Preintegrated:
        """Return the IMU up to a new keyframe at ``t`` [s]."""
        self.fixes, self._gaps, self._imu = fixes, imu_gaps(imu), imu
        self._measured = self._measurements(fixes.part(fixes.t > self.t - CLIMB_SPAN_S - 1.0), imu)
        return self._integrated(grid(imu, np.array([self.t, t])))

    def _integrated(self, g: ImuGrid, rows: slice = slice(None)) -> Preintegrated:
        """Return some rows of the IMU on a grid, integrated from the newest keyframe on."""
        state, part = self.state, ImuGrid(g.dt[rows], g.omega_b[rows], g.f_b[rows], g.at[:0])
        middle = self.t + part.dt.sum() / 2
        noise = next((_within(each, self._site.noise) for each in self._gaps if each.first < middle < each.last),
                     self._site.noise)  # fmt: skip
        earth_b = state.C_ob[-1].T @ self._heading().T @ self._site.earth_n
        return preintegrate(part, state.bg[-1], state.ba[-1], earth_b, noise)

    def _add_keyframe(self, t: float, part: Preintegrated | None) -> None:
        """Predict a keyframe at ``t`` [s] behind ``part`` of the IMU, None for the first; the oldest leaves."""
        while len(self.state.p) > self._frames + self.awaited:
            self._slide()
        if part is not None:
            last, site = self.state, self._site
            rated = replace(last, rate=part.rates[:1]) if last.rate is not None and len(last.p) == 1 else last
            self.state = rated.with_frame(*predicted(last, part, site), last.bg[-1], last.ba[-1], part.rates[-1])
            fix = self._fix(part, self._heading() @ last.C_ob[-1], site.pull(last.v[-1]))
            if self.wheel is not None:
                fix = self._with_wheel(self.wheel, fix, t, part)
            self._held = WindowMeasurements([*self._held.parts, part], [*self._held.fixes, fix])
        newest = self._held.fixes[-1]
        rests = newest.wheel is not None and newest.wheel.rest_weight > 0
        self._since = 0.0 if newest.v_weight.any() or rests else self._since + t - self.t
        self.t = t

    def _with_wheel(self, wheel: WheelAid, fix: KeyframeFix, t: float, part: Preintegrated) -> KeyframeFix:
        """Return the measurements at the newest keyframe, at ``t`` [s] behind ``part``, with the wheel's part."""
        C, v = self.state.C_ob[-1], self.state.v[-1]
        seen = wheel.measured(self.t, part, C.T @ self._site.pull(v))
        if seen is None:
            return fix
        v_b, slipped = C.T @ v, wheel.slips_now
        P = predicted_covariance(self._factor, self._solved, C, v_b, self._site.noise, part.dt)
        seen = wheel.judged(seen, t, part.dt, v_b, 1 + self.state.wheel, P, self._imu)
        if wheel.slips_now and not slipped:
            self._held = without_wheel(self._held, t - self.t, RETRACTED_S)
        return replace(fix, wheel=seen)

    @property
    def wheel_std(self) -> float:
        """1 sigma of the wheel's scale factor."""
        return float(np.sqrt(self.covariance(slice(WHEEL, WHEEL + 1))[0, 0]))

    def _fix(self, part: Preintegrated, C_nb: FloatArray, pull: FloatArray) -> KeyframeFix:
        return self._measured.at_end(self.t, part, C_nb, pull, self.antenna)

    def _solve(self) -> None:
        for _ in range(self._rounds):
            normal, free = assemble(
                self.state, self._prior, self._held, self._site, self.marks, self.marks.sights.seen,
                self._scale,
            )  # fmt: skip
            self._factor, self._solved = self._factorised(normal.A), self.last
            step = -self._factor.solve(normal.g)
            self.state = self.state.moved(step)
            self.marks.step(free.rows, free.step(step), self.state.held)
            if step @ normal.A @ step < STEP_TOLERANCE**2 * len(step):
                break

    def _factorised(self, A: FloatArray) -> Factor:
        """Return a factor of the window's normal equations: sights tie all keyframes, all else only neighbours."""
        is_chain = not len(self.marks.slot) and not len(self.state.held) and len(self._prior.at.p) <= 2
        return ChainFactor(A) if is_chain else Factor(A)

    def _slide(self) -> BackSubstitution:
        """Marginalise the oldest keyframe, and return how it went."""
        known = self.state
        if not len(self.marks.slot):  # nothing ties it but to the next, and to what the prior knows
            known = known.part(slice(max(2, len(self._prior.at.p))))
        held = self._held
        self._prior, gone = marginalised(known, self._prior, held, self._site, self.marks, self._scale)
        self.state = replace(self.state.part(slice(1, None)), held=self._prior.at.held)
        self._held = WindowMeasurements(held.parts[1:], held.fixes[1:])
        return gone

    def _heading(self) -> FloatArray:
        return rz(np.array(self.state.heading))[0]


def _within(gap: ImuGap, noise: ImuNoise) -> ImuNoise:
    """Return the noise with what a straight line over a gap misses."""
    gyro, accel = (std * np.sqrt(gap.length) for std in (gap.rate_std, gap.force_std))
    return replace(noise, gyro=float(np.hypot(noise.gyro, gyro)), accel=float(np.hypot(noise.accel, accel)))

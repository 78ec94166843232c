"""From campaigns to a solution: both triads, the bench, the residual, and what stayed open."""

from collections.abc import Sequence

import numpy as np
from scipy.special import gammaincc

from procedures.arrays import FloatArray
from procedures.bench_model import tilt_names
from procedures.campaign import Campaign
from procedures.errors import NotObservable
from procedures.frames import AXES
from procedures.hand_turns import GyroscopeFit, solve_gyroscope
from procedures.observations import TriadDwells, dwell_rates, refuse_wrong_faces, turn_totals
from procedures.solution import Estimate, FitQuality, Solution, StepResidual, TriadCalibration
from procedures.twelve_position import (
    JointFit,
    by_position,
    closed_form,
    missing_positions,
    solve_accelerometer,
)

DPH = 3600.0  # deg/h per deg/s
NEVER_EXCITED = ("accelerometer.cross_product", "accelerometer.cubic (as accelerometer.scale_factor)")


def solve(campaigns: Sequence[Campaign]) -> Solution:
    """Solve one unit's campaigns jointly.

    Raises
    ------
    NotObservable
        If neither triad can be solved.
    WrongFace
        If a dwell's vertical axis is not the one its position names.
    """
    accel, gyro = (dwell_rates(campaigns, triad) for triad in ("accelerometer", "gyroscope"))
    if accel is not None:
        refuse_wrong_faces(accel, [c.fixture.C_ib for c in campaigns])
    accelerometer = solve_accelerometer(campaigns, accel) if accel is not None else None
    turns = turn_totals(campaigns, gyro.noise) if gyro is not None else []
    gyroscope = solve_gyroscope(campaigns, gyro, turns, accelerometer) if gyro is not None else None
    if accelerometer is None and gyroscope is None:
        raise NotObservable("the scale factor and bias of either triad", missing_positions(campaigns, accel or gyro))
    return _Report(campaigns, accel, gyro, accelerometer, gyroscope).solution()


class _Report:
    """Puts the two fits into one solution."""

    def __init__(
        self,
        campaigns: Sequence[Campaign],
        accel: TriadDwells | None,
        gyro: TriadDwells | None,
        accelerometer: JointFit | None,
        gyroscope: GyroscopeFit | None,
    ) -> None:
        self.campaigns, self.accel, self.gyro = campaigns, accel, gyro
        self.accelerometer, self.gyroscope = accelerometer, gyroscope
        self.names: list[str] = []
        self.blocks: list[FloatArray] = []

    def solution(self) -> Solution:
        accelerometer = self._accelerometer()
        slab, parallelism = self._bench()
        gyroscope = self._gyroscope()
        return Solution(
            accelerometer=accelerometer, gyroscope=gyroscope, slab_tilt=slab, parallelism=parallelism,
            quality=self._quality(), names=tuple(self.names), covariance=_block_diagonal(self.blocks),
            reference_temperature=self._temperature(), residuals=self._residuals(),
            not_observable=self._not_observable(), warnings=self._warnings(), unused_steps=self._unused(),
        )  # fmt: skip

    def _accelerometer(self) -> TriadCalibration | None:
        if self.accelerometer is None or self.accel is None:
            return None
        joint, counts = self.accelerometer, self.campaigns[0].counts
        k, E, D = self._triad(joint, "accelerometer", 1.0)
        twelve = two = None
        table = by_position(self.accel, self.campaigns[0].fixture.C_ib)
        if table is not None:
            form = closed_form(*table)
            order = np.argmax(np.abs(self.campaigns[0].fixture.C_ib), axis=1)
            twelve = Estimate(form.bias_12_position[order], form.bias_12_position_std[order], "g")
            two = Estimate(form.bias_two_direction[order], form.bias_two_direction_std[order], "g")
        unit = "count/(g s)" if counts else "output/g"
        return TriadCalibration(Estimate(*k, unit), Estimate(*E, "1"), Estimate(*D, "g"), twelve, two)

    def _gyroscope(self) -> TriadCalibration | None:
        if self.gyroscope is None:
            return None
        k, E, D = self._triad(self.gyroscope.joint, "gyroscope", DPH)
        unit = "count/deg" if self.campaigns[0].counts else "output/(deg/s)"
        return TriadCalibration(Estimate(*k, unit), Estimate(*E, "1"), Estimate(*D, "deg/h"))

    def _triad(self, joint: JointFit, name: str, bias_unit: float) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Turn K and b into k, E and D with their joint covariance; add it to the solution's."""
        value, J = _scale_misalignment_bias(joint.K, joint.b, bias_unit)
        covariance = J @ joint.fit.covariance[:12, :12] @ J.T
        covariance[:3, :3] += np.diag(_perpendicularity_variance(joint, self.accelerometer))
        sigma = np.sqrt(np.diag(covariance))
        self.names += [f"{name}.scale_factor.{a}" for a in AXES]
        self.names += [f"{name}.misalignment.{a}{b}" for a in AXES for b in AXES]
        self.names += [f"{name}.bias.{a}" for a in AXES]
        self.blocks.append(covariance)
        split = [(slice(0, 3), (3,)), (slice(3, 12), (3, 3)), (slice(12, 15), (3,))]
        return tuple((value[at].reshape(shape), sigma[at].reshape(shape)) for at, shape in split)

    def _bench(self) -> tuple[Estimate | None, Estimate | None]:
        """Slab tilt of the first campaign and parallelism of its cube, as the accelerometers found them."""
        if self.accelerometer is None:
            return None, None
        bench, fit = self.accelerometer.bench, self.accelerometer.fit
        cube = bench.cube_slice(bench.placements[0].cube).start
        index = 12 + np.array([0, 1, *range(cube, cube + 6)])
        covariance = fit.covariance[np.ix_(index, index)]
        sigma = np.sqrt(np.diag(covariance))
        self.names += ["slab.tilt.east", "slab.tilt.north", *(f"fixture.parallelism.{n}" for n in tilt_names())]
        self.blocks.append(covariance)
        value = fit.x[index]
        return (
            Estimate(value[:2], sigma[:2], "rad"),
            Estimate(value[2:].reshape(3, 2), sigma[2:].reshape(3, 2), "rad"),
        )

    def _quality(self) -> FitQuality:
        fits = [f for f in (self.accelerometer, self.gyroscope.joint if self.gyroscope else None) if f is not None]
        chi2 = sum(_chi2(f)[0] for f in fits)
        dof = sum(_chi2(f)[1] for f in fits)
        p = float(gammaincc(dof / 2, chi2 / 2)) if dof > 0 else 1.0
        rms: dict[str, float] = {}
        for name, each, scale in (("accelerometer_rms_g", self.accelerometer, 1.0),
                                  ("gyroscope_rms_dph", self.gyroscope.joint if self.gyroscope else None, DPH)):  # fmt: skip
            if each is not None:
                residual, _ = _dwell_residuals(each)
                rms[name] = float(np.sqrt(np.mean((residual / _k(each)) ** 2))) * scale
        return FitQuality(float(chi2), dof, p, **rms)

    def _temperature(self) -> float | None:
        values = np.concatenate([d.series.temperature for c in self.campaigns for d in c.dwells])
        values = values[np.isfinite(values)]
        return float(values.mean()) if len(values) else None

    def _residuals(self) -> tuple[StepResidual, ...]:
        found: list[StepResidual] = []
        for triad, joint, scale, unit in (
            ("accelerometer", self.accelerometer, 1.0, "g"),
            ("gyroscope", self.gyroscope.joint if self.gyroscope else None, DPH, "deg/h"),
        ):
            if joint is None:
                continue
            residual, sigma = _dwell_residuals(joint)
            for (_, dwell), r, s in zip(joint.seen.dwells, residual / _k(joint), sigma / _k(joint), strict=True):
                found.append(StepResidual(dwell.name, "dwell", triad, dwell.position, r * scale, s * scale, unit))
        if self.gyroscope is not None:
            found += _turn_residuals(self.gyroscope)
        return tuple(found)

    def _not_observable(self) -> tuple[str, ...]:
        found = []
        for triad, fit in (("accelerometer", self.accelerometer), ("gyroscope", self.gyroscope)):
            if fit is None:
                found += [f"{triad}.{part}" for part in ("scale_factor", "misalignment", "bias")]
        bench = self.accelerometer.bench if self.accelerometer else None
        if bench is not None:
            held = [c for c, ok in zip("xyz", bench.certified_pairs(0), strict=True) if not ok]
            found += [f"fixture.perpendicularity.{n} (with misalignment)" for n in tilt_names() if n[0] in held]
            if held:
                found.append("accelerometer.quadratic (with accelerometer.bias and fixture.parallelism)")
            found += NEVER_EXCITED
        return tuple(found)

    def _warnings(self) -> tuple[str, ...]:
        found = []
        if self.gyroscope is not None:
            found += [f"{name}: samples were lost while turning; the turn is not used" for name in self.gyroscope.broken]
            for turn, shape in zip(self.gyroscope.turns, self.gyroscope.geometry, strict=True):
                if shape.open_ends:
                    found.append(
                        f"{turn.record.name}: less than 2 s of rest at an end; "
                        f"its closure is taken as {np.degrees(shape.closure_std):.2g} deg"
                    )
        if self.gyroscope is None and self.gyro is not None:
            lacking = [a for a in AXES if not any(t.axis == a for c in self.campaigns for t in c.turns)]
            what = f"no turn about {', '.join(lacking)}" if lacking else "the turns do not determine it"
            found.append(f"gyroscope not solved: its scale factor is unknown ({what})")
        if self.accelerometer is None and self.accel is not None:
            lacking = missing_positions(self.campaigns, self.accel)
            found.append(f"accelerometer not solved: missing {', '.join(lacking)}")
        return (*found, *self._few_counts())

    def _few_counts(self) -> list[str]:
        found = []
        for triad, seen in (("accelerometer", self.accel), ("gyroscope", self.gyro)):
            for (_, dwell), row in zip(seen.dwells if seen else (), seen.estimates if seen else (), strict=True):
                for axis, estimate in zip(AXES, row, strict=True):
                    if estimate.interval is not None:
                        low, high = estimate.interval
                        found.append(
                            f"{dwell.name}: {triad} {axis} shows {estimate.edges} count edges; "
                            f"its rate is only known to lie in [{low:.3g}, {high:.3g}] count/s"
                        )
        return found

    def _unused(self) -> tuple[str, ...]:
        if self.gyroscope is None:
            return tuple(turn.name for c in self.campaigns for turn in c.turns)
        return self.gyroscope.broken


def _k(joint: JointFit) -> FloatArray:
    k: FloatArray = np.linalg.norm(joint.K, axis=1)
    return k


def _scale_misalignment_bias(K: FloatArray, b: FloatArray, bias_unit: float) -> tuple[FloatArray, FloatArray]:
    """Return k (3), E (9), D (3) in one vector (15,) and its Jacobian (15, 12) with respect to K (9), b (3)."""
    k = np.linalg.norm(K, axis=1)
    E, D = K / k[:, None], b / k
    J = np.zeros((15, 12))
    for q in range(3):
        row = slice(3 * q, 3 * q + 3)
        J[q, row] = E[q]
        J[3 + 3 * q : 6 + 3 * q, row] = (np.eye(3) - np.outer(E[q], E[q])) / k[q]
        J[12 + q, row] = -bias_unit * D[q] / k[q] * E[q]
        J[12 + q, 9 + q] = bias_unit / k[q]
    return np.concatenate((k, E.ravel(), D * bias_unit)), J


def _perpendicularity_variance(joint: JointFit, accelerometer: JointFit | None) -> FloatArray:
    """Return the variance (3,) that an uncertified cube's perpendicularity adds to k.

    Turning K into the mean cube's axes changes ``|K_q|`` by ``k sum_(p<r) E_qp E_qr (q_pr + q_rp)``. How large q may
    be is judged from the parallelism seen: with face tilts of equal variance s^2, p has 2 s^2 and q s^2 / 2. The
    six values give s^2 with six degrees of freedom, hence the mean of its posterior, sum p^2 / (2 (6 - 2)).
    """
    E = joint.K / _k(joint)[:, None]
    bench = joint.bench
    held = [not certified for certified in bench.certified_pairs(0)]
    source = accelerometer or joint
    begin = 12 + source.bench.cube_slice(0).start
    p = source.fit.x[begin : begin + 6].reshape(3, 2)[held]
    if not p.size or accelerometer is None:
        return np.zeros(3)
    q_variance = float(np.sum(p**2)) / (2 * max(p.size - 2, 1)) / 2
    variance = np.zeros(3)
    for a, c in ((0, 1), (0, 2), (1, 2)):
        variance += (E[:, a] * E[:, c]) ** 2 * q_variance * (held[a] + held[c])
    return variance * _k(joint) ** 2


def _dwell_residuals(joint: JointFit) -> tuple[FloatArray, FloatArray]:
    """Return residual and its 1 sigma (n, 3) [output/s] of every dwell."""
    n = len(joint.seen.dwells)
    sigma = np.sqrt(joint.seen.std**2 + joint.excess**2)
    free = np.sqrt(np.maximum(1 - joint.fit.leverage[: 3 * n].reshape(n, 3), 1e-6))
    return joint.fit.residual[: 3 * n].reshape(n, 3) * sigma, sigma * free


def _turn_residuals(gyroscope: GyroscopeFit) -> list[StepResidual]:
    """Residual (3,) of every turn [deg]; the closure is part of the fit, so what is left is smaller than it."""
    joint, found = gyroscope.joint, []
    n = len(joint.seen.dwells)
    for i, turn in enumerate(gyroscope.turns):
        rows = slice(3 * (n + i), 3 * (n + i) + 3)
        sigma = np.sqrt(turn.std**2 + (joint.excess * turn.seconds) ** 2) / _k(joint)
        free = np.sqrt(np.maximum(1 - joint.fit.leverage[rows], 1e-6))
        found.append(
            StepResidual(turn.record.name, "turn", "gyroscope", turn.record.start_position,
                         joint.fit.residual[rows] * sigma, sigma * free, "deg")  # fmt: skip
        )
    return found


def _chi2(joint: JointFit) -> tuple[float, int]:
    """Return chi-square over counting noise alone, and the degrees of freedom."""
    n = len(joint.seen.dwells)
    ratio = (1 + (joint.excess / joint.seen.std) ** 2).ravel()
    rows = joint.fit.residual.copy()
    rows[: 3 * n] *= np.sqrt(ratio)
    held = sum(2 * (not ok) for ok in joint.bench.certified_pairs(0)) * joint.bench.cubes
    return float(rows @ rows), joint.fit.dof - 0 * held


def _block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    size = sum(len(b) for b in blocks)
    whole = np.zeros((size, size))
    at = 0
    for block in blocks:
        whole[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return whole

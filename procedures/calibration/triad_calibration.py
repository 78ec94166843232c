"""From a joint fit's K = diag(k) E and b = k D to k, E and D with their covariance.

What tilts that a campaign leaves open move k, E and D by in second order.
Where slab or faces are only known to be level within a plausible range, as the slab is with one heading a face, k,
E and D hang on the tilt that was found. Solved again for each tilt ``z`` they are ``f(0) + g z + z H z / 2``. The
fit's covariance holds g; where g is small at the tilt that was found, H is what is left. For z of unit normals
``E[(z H z / 2)^2] = tr(H H) / 2 + (tr H)^2 / 4`` (moments of a quadratic form; JCGM 100:2008, 5.1.2, note).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, TriadCalibration
from procedures.frames import AXES
from procedures.free_positions.gyroscopes_from_moves import MovesFit
from procedures.twelve_positions.accelerometer_fit import TriadFit, by_position, closed_form, specific_force
from procedures.twelve_positions.bench_parameters import mean_axes, mean_cube, skew_jacobian, skew_variance
from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY

OPEN_TILT_RAD = 3e-4  # rad, 1 sigma: half its square is 0.05 ppm


def second_order(joint: TriadFit, value: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return the covariance (15, 15) that open tilts add in second order; zero where none is open.

    ``value`` takes parameters (p,) as the fit's to k (3), E (9), D (3). A fit with rests in free attitudes knows K
    without the bench: nothing is added.
    """
    bench, x = joint.bench, joint.fit.x
    none = np.zeros((15, 15))
    if not joint.seen.dwells or joint.rests is not None or joint.quadratic or joint.is_turned_freely:
        return none
    shared = slice(12, 12 + bench.shared)
    variance, ways = np.linalg.eigh(joint.fit.covariance[shared, shared])
    is_open = variance > OPEN_TILT_RAD**2
    if not is_open.any():
        return none
    steps = (np.sqrt(variance[is_open]) * ways[:, is_open]).T

    def at(step: FloatArray) -> FloatArray:
        moved = x.copy()
        moved[shared] += step
        moved[:12] = _solved(joint, moved[12 : 12 + bench.size])
        return value(moved)

    level = at(np.zeros(bench.shared))

    def bend(step: FloatArray) -> FloatArray:
        return (at(step) + at(-step)) / 2 - level

    own = [bend(step) for step in steps]
    H = np.array([
        [bend(a + b) - own[i] - own[j] if i != j else 2 * own[i] for j, b in enumerate(steps)]
        for i, a in enumerate(steps)
    ])  # fmt: skip
    trace = np.einsum("iia->a", H)
    found: FloatArray = np.einsum("ija,ijb->ab", H, H) / 2 + np.outer(trace, trace) / 4
    return found


def _solved(joint: TriadFit, bench: FloatArray) -> FloatArray:
    """Return K (9) and b (3) that the dwells' rates give on a bench with these parameters (p,)."""
    u = specific_force(joint.bench, bench)
    A = np.column_stack((u, np.ones(len(u))))
    weight = 1 / joint.sigma
    channels = zip(weight.T, joint.seen.rate.T, strict=True)
    rows = [np.linalg.lstsq(A * w[:, None], r * w, rcond=None)[0] for w, r in channels]
    return np.concatenate((*(row[:3] for row in rows), [row[3] for row in rows]))


# Neighbours that have a bias's instability in common: minutes, as the correlation of a FOG's
CORRELATED_DWELLS = 3
TILT_STEP_RAD = 1e-5  # rad, for central differences of the axes that E refers to
SCALE_AND_BIAS_ROWS = np.array([0, 1, 2, 12, 13, 14])  # k and D of the vector k (3), E (9), D (3)


@dataclass(frozen=True, slots=True, eq=False)
class TriadVector:
    """k (3), E (9) by rows and D (3) in one vector (15,), its names and covariance (15, 15).

    ``jacobian`` (15, p) takes the fit's parameters to it, K (9) and b (3) first. ``second`` (15,) is the share of
    the variance that tilts left open have in second order.
    """

    value: FloatArray
    jacobian: FloatArray
    covariance: FloatArray
    names: tuple[str, ...]
    bias_unit: str
    second: FloatArray = field(default_factory=lambda: np.zeros(15))

    def calibration(self, counts: bool) -> TriadCalibration:
        """Return the parts with 1 sigma each; ``counts`` says whether the output is counts."""
        std = np.sqrt(np.diag(self.covariance))
        k, E, D = slice(0, 3), slice(3, 12), slice(12, 15)
        return TriadCalibration(
            scale_factor=Estimate(self.value[k], std[k], scale_unit(self.names[0].split(".")[0], counts)),
            misalignment=Estimate(self.value[E].reshape(3, 3), std[E].reshape(3, 3), "1"),
            bias=Estimate(self.value[D], std[D], self.bias_unit),
        )


def scale_unit(triad: str, counts: bool) -> str:
    """Return a triad's unit of scale factor, as written in files."""
    if triad == "accelerometer":
        return "count/(g s)" if counts else "output/g"
    return "count/deg" if counts else "output/(deg/s)"


def triad_vector(joint: TriadFit, triad: str, accelerometer: TriadFit | None) -> TriadVector:
    """Refer a fit to the mean cube and turn it into k, E and D.

    Scatter from dwell to dwell beyond counting noise is taken as bias instability, which changes slowly: the
    mean over the dwells averages it less than independent draws. The drift of an unsettled unit is common to all
    of them: its bias when it has settled differs by as much as it moved in that time. An uncertified cube's skew
    adds to the sigma of k, and of accelerometers' D (`procedures.twelve_positions.bench_parameters`).
    """
    unit, per = ("g", 1.0) if triad == "accelerometer" else ("deg/h", DEG_H_PER_DEG_S)
    C_sb = joint.bench.campaigns[0].fixture.C_sb
    skew_seen = (accelerometer or joint).bench.skew_known()
    value, J = scale_misalignment_bias(joint.K @ reference_axes(joint, skew_seen), joint.b, per)
    J = J @ _jacobian_in_reference_axes(joint, skew_seen)
    covariance = J @ joint.fit.covariance @ J.T
    if accelerometer is not None and not skew_seen and not joint.bench.skew_seen:
        p = accelerometer.bench.parallelism(accelerometer.fit.x[12:])
        variance = skew_variance(p, accelerometer.bench.held_pairs(0))
        scale, bias = skew_jacobian(p, C_sb.T @ value[3:12].reshape(3, 3) @ C_sb)
        rows = np.vstack((value[:3, None] * (np.abs(C_sb) @ scale), C_sb @ bias * (triad == "accelerometer")))
        covariance[np.ix_(SCALE_AND_BIAS_ROWS, SCALE_AND_BIAS_ROWS)] += rows * variance @ rows.T
    covariance[12:, 12:] += np.diag(sum(common_variance(joint, value[:3] / per)))
    second = np.zeros((15, 15))
    if triad == "accelerometer":  # gyroscopes see rotations between faces, in which the slab's tilt cancels

        def moved(x: FloatArray) -> FloatArray:
            at = replace(joint, fit=replace(joint.fit, x=x))
            return scale_misalignment_bias(at.K @ reference_axes(at, skew_seen), at.b, per)[0]

        second = second_order(joint, moved)
    return TriadVector(value, J, covariance + second, vector_names(triad), unit, np.diag(second))


def with_clock(vector: TriadVector, change: FloatArray, std: float) -> TriadVector:
    """Return the vector with a time base open to ``std``, relative.

    ``change`` (15,) is that of the vector, in its units, per relative error of the time base.
    """
    return replace(vector, covariance=vector.covariance + np.outer(change, change) * std**2)


def common_variance(joint: TriadFit, k: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what dwells have in common, as variances (3,) of D.

    Bias instability, a drift that is stated, and how far apart turn-ons were of which D is the mean.

    ``k`` (3,) is the scale factor in output/s per unit of D.
    """
    n = len(joint.seen.dwells)
    if not n:
        return np.zeros(3), np.zeros(3), np.zeros(3)
    shared = (joint.excess / k) ** 2 * (min(CORRELATED_DWELLS, n) - 1) / n
    return shared, np.mean((joint.unsettled / k) ** 2, axis=0), (joint.spread / k) ** 2


def moves_vector(moves: MovesFit, accelerometer: TriadFit) -> TriadVector:
    """Turn the moves' fit into k, E and D, in the axes that the accelerometers' E refers to.

    The covariance holds the accelerometers' share, and bias instability as `triad_vector` does.
    """
    axes = reference_axes(accelerometer, accelerometer.bench.skew_known())
    value, J = scale_misalignment_bias(moves.K @ axes, moves.b, DEG_H_PER_DEG_S)
    G = moves.by_accelerometer
    covariance = J @ (moves.fit.covariance[:12, :12] + G @ accelerometer.fit.covariance[:12, :12] @ G.T) @ J.T
    n = len(moves.rate_error)
    covariance[12:, 12:] += (
        np.eye(3) * (moves.scatter[1] * DEG_H_PER_DEG_S) ** 2 * (min(CORRELATED_DWELLS, n) - 1) / n
    )
    return TriadVector(value, J, covariance, vector_names("gyroscope"), "deg/h")


def reference_axes(joint: TriadFit, skew_seen: bool) -> FloatArray:
    """Return unit columns (3, 3), IMU axes, that E refers to: the mean cube or the orthogonal axes nearest."""
    bench = joint.bench
    if not bench.cubes or not any(bench.held_pairs(0)):
        return np.eye(3)
    cube = (mean_axes if skew_seen else mean_cube)(bench.perpendicularity(joint.fit.x[12:]))
    C_sb = bench.campaigns[0].fixture.C_sb
    return C_sb @ cube @ C_sb.T


def _jacobian_in_reference_axes(joint: TriadFit, skew_seen: bool) -> FloatArray:
    """Return the Jacobian (12, p) of K and b, K in the axes that E refers to, by the fit's parameters.

    The axes follow the face pairs' q, which follows p: what p leaves open moves K and its axes alike.
    """
    axes = reference_axes(joint, skew_seen)
    T = np.zeros((12, len(joint.fit.x)))
    T[:9, :9], T[9:, 9:12] = np.kron(np.eye(3), axes.T), np.eye(3)
    if not joint.bench.cubes or not any(joint.bench.held_pairs(0)):
        return T
    begin = 12 + joint.bench.cube_slice(0).start + 6
    for column in range(begin, begin + 6):
        d = np.zeros(len(joint.fit.x))
        d[column] = TILT_STEP_RAD
        up, down = (
            reference_axes(replace(joint, fit=replace(joint.fit, x=joint.fit.x + sign * d)), skew_seen)
            for sign in (1, -1)
        )
        T[:9, column] = (joint.K @ (up - down) / (2 * TILT_STEP_RAD)).ravel()
    return T


def vector_names(triad: str) -> tuple[str, ...]:
    """Return the names of k (3), E (9) and D (3) of a triad."""
    names = [f"{triad}.scale_factor.{a}" for a in AXES]
    names += [f"{triad}.misalignment.{a}{b}" for a in AXES for b in AXES]
    return (*names, *(f"{triad}.bias.{a}" for a in AXES))


def scale_misalignment_bias(K: FloatArray, b: FloatArray, per: float) -> tuple[FloatArray, FloatArray]:
    """Return k (3), E (9), D (3) in one vector (15,), and its Jacobian (15, 12) by ``K`` (3, 3) and ``b`` (3,).

    K is in output/s per unit of the input, b in output/s; D comes in that unit times ``per``.
    """
    k = np.linalg.norm(K, axis=1)
    E, D = K / k[:, None], b / k
    J = np.zeros((15, 12))
    for q in range(3):
        row = slice(3 * q, 3 * q + 3)
        J[q, row] = E[q]
        J[3 + 3 * q : 6 + 3 * q, row] = (np.eye(3) - np.outer(E[q], E[q])) / k[q]
        J[12 + q, row] = -per * D[q] / k[q] * E[q]
        J[12 + q, 9 + q] = per / k[q]
    return np.concatenate((k, E.ravel(), D * per)), J


def paper_biases(joint: TriadFit) -> tuple[Estimate | None, Estimate | None]:
    """Return both biases [g] of Yao 2018, 12-position and two-direction; None without all positions."""
    C_sb = joint.bench.campaigns[0].fixture.C_sb
    table = by_position(joint.bench.campaigns, joint.seen, C_sb)
    if table is None:
        return None, None
    form, order = closed_form(*table), np.argmax(np.abs(C_sb), axis=1)
    local = joint.bench.campaigns[0].site.gravity / STANDARD_GRAVITY  # the formulas' unit is the local g
    twelve = Estimate(form.bias_12_position[order] * local, form.bias_12_position_std[order] * local, "g")
    two = Estimate(form.bias_two_direction[order] * local, form.bias_two_direction_std[order] * local, "g")
    return twelve, two

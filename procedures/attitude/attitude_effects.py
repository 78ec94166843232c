"""Effects that a filter's model may lack, and the residual of a log as their evidence.

A column is what a unit of the coefficient adds to what is measured, beyond the base model: nothing but gravity
without a speed, ``omega x (V, 0, 0)`` with one.

The residual of a log is evidence for the loop of `procedures.diagnosis`. Windows of a second or more give rows of
two kinds. *Gyroscope*: the reference's down vector at the end, less that at the start carried over by the rates.
*Accelerometer*, with truth only: the mean specific force less the model's, in g. Without truth the reference is
the accelerometers' own attitude, and their effects show in the first kind.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.counts.sample_times import GAP_PERIODS
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation, ExcitationStep
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import AXES, TRIADS, rotation
from procedures.inference.priors import FACTOR
from procedures.inference.smooth_functions import Function, waves

SMOOTH_S = 0.2  # of what is differentiated


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeMotion:
    """A log as effects see it: rates and forces as measured, speed V (n,) [m/s] (zero where none is known)."""

    log: AttitudeLog
    speed: FloatArray
    speed_slope: FloatArray
    rate_slope: FloatArray

    @classmethod
    def of(cls, log: AttitudeLog, speed: FloatArray) -> "AttitudeMotion":
        """Differentiate what needs it, smoothed over `SMOOTH_S`."""
        rows = max(round(SMOOTH_S / log.nominal), 1)
        return cls(log, speed, slope(speed[:, None], log.t, rows)[:, 0], slope(log.omega_b, log.t, rows))


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeEffect:
    """A cause: its coefficients, unit, 1 sigma of what they may plausibly be, and its columns.

    ``rate`` and ``force`` return (n, 3, k) [rad/s], [m/s2] a unit, None where it adds nothing. ``needs_truth``
    where gyros and accelerometers alone cannot show it, ``needs_speed`` where a speed is part of it;
    ``of_velocity`` where a filter that estimates velocity holds it already. ``is_of_aid``: it is corrected in the
    speed itself.
    """

    name: str
    coefficients: tuple[str, ...]
    unit: str
    plausible: float
    separate_by: str
    rate: Callable[[AttitudeMotion], FloatArray] | None = None
    force: Callable[[AttitudeMotion], FloatArray] | None = None
    needs_truth: bool = False
    needs_speed: bool = False
    of_velocity: bool = False
    is_of_aid: bool = False


def slope(values: FloatArray, t: FloatArray, rows: int) -> FloatArray:
    """Return the derivative of ``values`` (n, k) by ``t`` (n,) [s], each column a running mean over ``rows``."""
    kernel = np.ones(rows) / rows
    padded = np.pad(values, ((rows // 2, rows - 1 - rows // 2), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=1)
    found: FloatArray = np.gradient(smooth, t, axis=0)
    return found


def _unit(motion: AttitudeMotion) -> FloatArray:
    return np.broadcast_to(np.eye(3), (len(motion.log.t), 3, 3))


def _per_axis(values: FloatArray) -> FloatArray:
    return values[:, :, None] * np.eye(3)


def _crossed(values: FloatArray) -> FloatArray:
    """Return columns (n, 3, 3) of a small rotation vector that turns vectors (n, 3) as the IMU sees them."""
    return np.cross(np.eye(3)[None], values[:, None, :]).transpose(0, 2, 1)


def _turning(motion: AttitudeMotion, axis: int, speed: FloatArray) -> FloatArray:
    """Return ``omega x V e_axis`` as one column (n, 3, 1)."""
    return np.cross(motion.log.omega_b, speed[:, None] * np.eye(3)[axis])[:, :, None]


def _lever(motion: AttitudeMotion) -> FloatArray:
    w, axes = motion.log.omega_b[:, None, :], np.eye(3)[None]
    found = np.cross(motion.rate_slope[:, None, :], axes) + np.cross(w, np.cross(w, axes))
    return found.transpose(0, 2, 1)


def _along_x(motion: AttitudeMotion) -> FloatArray:
    column = np.zeros((len(motion.log.t), 3, 1))
    column[:, 0, 0] = motion.speed_slope
    return column


TURN = "turns both ways at two speeds"
ATTITUDE_EFFECTS = (
    AttitudeEffect("velocity.forward", ("value",), "1", 1.0, TURN, needs_speed=True,
                   force=lambda m: _turning(m, 0, m.speed)),
    AttitudeEffect("velocity.attack", ("value",), "rad", 0.1, "rolling in and out of turns", needs_speed=True,
                   of_velocity=True, force=lambda m: _turning(m, 2, m.speed)),
    AttitudeEffect("velocity.slip", ("value",), "rad", 0.05, "rolling and pitching at speed", needs_speed=True,
                   of_velocity=True, force=lambda m: _turning(m, 1, m.speed)),
    AttitudeEffect("velocity.rate", ("value",), "1", 1.0, "braking and speeding up on a straight line",
                   needs_speed=True, of_velocity=True, force=_along_x),
    AttitudeEffect("aid.scale", ("value",), "1", 0.1, TURN, needs_speed=True, is_of_aid=True,
                   force=lambda m: _turning(m, 0, m.speed)),
    AttitudeEffect("aid.time_offset", ("value",), "s", 0.5, "turns while the speed changes", needs_speed=True,
                   is_of_aid=True, force=lambda m: _turning(m, 0, m.speed_slope)),
    AttitudeEffect("mounting.angle", AXES, "rad", 0.02, "rests far apart in roll and pitch", needs_truth=True,
                   rate=lambda m: _crossed(m.log.omega_b), force=lambda m: _crossed(m.log.f_b)),
    AttitudeEffect("mounting.lever_arm", AXES, "m", 1.0, "fast turning on the spot", force=_lever),
    AttitudeEffect("gyroscope.bias", AXES, "rad/s", 0.02, "a minute of rest", rate=_unit),
    AttitudeEffect("gyroscope.scale", AXES, "1", 0.01, "closed turns about each axis",
                   rate=lambda m: _per_axis(m.log.omega_b)),
    AttitudeEffect("accelerometer.bias", AXES, "m/s2", 0.1, "rests in opposite positions", force=_unit),
)  # fmt: skip


WINDOW_S, BLIND_WINDOW_S, MAX_WINDOWS = 1.0, 4.0, 600  # without truth drift must outgrow the accelerometers
STRETCHES = 10  # parts of a log, by which its rows are named
MEDIAN_OF_NORMAL = 0.6745  # of the size of a normal variable, in sigmas
NOISE_DOF = 1.0  # nothing is known of the noise but its scatter from window to window


@dataclass(frozen=True, slots=True, eq=False)
class ResidualWindows:
    """Row numbers (m, k) of the windows that are used, and the reference's down vector (n, 3) along the log."""

    rows: IntArray
    reference: FloatArray
    has_truth: bool


def windows(motion: AttitudeMotion, base: FloatArray, gravity: float, use: BoolArray) -> ResidualWindows:
    """Cut the rows to ``use`` (n,) into windows without gap or unknown reference.

    ``base`` (n, 3) [m/s2] is what the model adds to gravity in the specific force.
    """
    log = motion.log
    truth = log.true_down
    has_truth = truth is not None and bool(np.isfinite(truth).any())
    reference = truth if truth is not None and has_truth else (base - log.f_b) / gravity
    span = max(WINDOW_S if has_truth else BLIND_WINDOW_S, float(use.sum()) * log.nominal / MAX_WINDOWS)
    k = max(round(span / log.nominal), 2)
    m = len(log.t) // k
    rows = np.arange(m * k).reshape(m, k)
    fine = use & np.isfinite(reference).all(axis=1) & (log.intervals < GAP_PERIODS * log.nominal)
    if not has_truth:  # the mean direction stands for that of the window's middle
        average = max(round(WINDOW_S / log.nominal), 1)
        kernel = np.ones(average) / average
        reference = np.stack([np.convolve(column, kernel, "same") for column in reference.T], axis=1)
        reference /= np.linalg.norm(reference, axis=1)[:, None]
    return ResidualWindows(rows[fine[rows].all(axis=1)], reference, has_truth)


def propagated_residual(
    motion: AttitudeMotion, cut: ResidualWindows, columns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return residual (m, 3) and columns (m, 3, k) of the gyroscope rows; ``columns`` (n, 3, k) [rad/s]."""
    log, first = motion.log, cut.rows[:, 0]
    down = cut.reference[first]
    H = np.zeros((len(first), 3, columns.shape[2]))
    dt = log.intervals
    for at in cut.rows.T[1:]:
        R = np.swapaxes(rotation(log.omega_b[at] * dt[at, None]), 1, 2)  # what the body sees turns back
        down = np.einsum("mij,mj->mi", R, down)
        H = R @ H + np.cross(columns[at] * dt[at, None, None], down[:, :, None], axis=1)
    return cut.reference[cut.rows[:, -1]] - down, H


def reference_columns(
    motion: AttitudeMotion, cut: ResidualWindows, columns: FloatArray, gravity: float
) -> FloatArray:
    """Return columns (m, 3, k) of the gyroscope rows by effects on the reference, the specific force [m/s2]."""
    d = cut.reference
    across = -(columns - d[:, :, None] * np.einsum("ni,nik->nk", d, columns)[:, None, :]) / gravity
    start = across[cut.rows[:, 0]]
    for at in cut.rows.T[1:]:
        R = np.swapaxes(rotation(motion.log.omega_b[at] * motion.log.intervals[at, None]), 1, 2)
        start = R @ start
    found: FloatArray = across[cut.rows[:, -1]] - start
    return found


def evidence_of(
    motion: AttitudeMotion, base: FloatArray, cut: ResidualWindows, effects: tuple[AttitudeEffect, ...],
    held: tuple[AttitudeEffect, ...], gravity: float, at_speed: bool,
) -> tuple[Evidence, dict[str, list[Candidate]]]:  # fmt: skip
    """Return the evidence and a candidate per effect; ``held`` are those that the model estimates anyway.

    ``base`` (n, 3) [m/s2] as in `windows`; ``at_speed`` where the base model has ``omega x V``: an error of the
    rates then is one of the model's force.
    """
    sizes = [len(each.coefficients) for each in (*effects, *held)]
    n, ends = len(motion.log.t), np.cumsum([0, *sizes])
    rates, forces = np.zeros((n, 3, ends[-1])), np.zeros((n, 3, ends[-1]))
    for i, each in enumerate((*effects, *held)):
        at = slice(int(ends[i]), int(ends[i + 1]))
        rates[:, :, at] = 0.0 if each.rate is None else each.rate(motion)
        forces[:, :, at] = 0.0 if each.force is None else each.force(motion)
    if at_speed:
        forces -= np.cross(rates, (motion.speed[:, None] * [1.0, 0.0, 0.0])[:, :, None], axis=1)
    left, H = propagated_residual(motion, cut, rates)
    blocks = [(left, H, 1)]
    if cut.has_truth:
        off = (motion.log.f_b - base + gravity * cut.reference) / gravity
        blocks.append((off[cut.rows].mean(axis=1), forces[cut.rows].mean(axis=1) / gravity, 0))
    else:
        blocks[0] = (left, H + reference_columns(motion, cut, forces, gravity), 1)
    residual = np.concatenate([block[0].ravel() for block in blocks])
    columns = np.concatenate([block[1].reshape(-1, ends[-1]) for block in blocks])
    triad = np.concatenate([np.full(block[0].size, block[2]) for block in blocks])
    stretch = np.tile(np.repeat(np.arange(len(left)) * STRETCHES // max(len(left), 1), 3), len(blocks))
    sigma = _scatter(residual, triad)
    made = _evidence(residual, sigma, -columns[:, ends[len(effects)] :], triad, stretch)
    pool = {
        each.name: [_candidate(each, columns[:, ends[i] : ends[i + 1]], made.A.shape[1])]
        for i, each in enumerate(effects)
    }
    return made, pool


def functions_of_time(evidence: Evidence) -> dict[str, Function]:
    """Return by name what may act without a name: of each kind of rows and axis, a smooth function of time."""
    found = dict[str, Function]()
    for number, triad in enumerate(TRIADS):
        for axis in range(3):
            rows = np.flatnonzero((evidence.triad == number) & (evidence.axis == axis))
            if not len(rows):
                continue
            options = list[tuple[float, FloatArray, str]]()
            for note, values, std in waves((np.arange(len(rows)) + 0.5) / len(rows)):
                H = np.zeros((len(evidence.residual), len(values)))
                H[rows] = np.stack(values, axis=1) * std
                options.append((1.0, H / np.linalg.norm(H), note))
            found[f"a function of time, {triad} {AXES[axis]}"] = Function(options)
    return found


def _evidence(
    residual: FloatArray, sigma: FloatArray, A: FloatArray, triad: IntArray, stretch: IntArray
) -> Evidence:
    n = len(residual)
    none, nothing, none_3x3 = np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3, 3))
    steps = tuple(ExcitationStep(f"stretch {i + 1}", "rate", 0, 0, "") for i in range(STRETCHES))
    excitation = Excitation(nothing, nothing, nothing, nothing, nothing, nothing, none, none, none, none, {},
                np.zeros(0, np.int64), none_3x3, none_3x3, none_3x3, steps)  # fmt: skip
    return Evidence(
        residual=residual, sigma=sigma, A=A, triad=triad, kind=np.full(n, KINDS.index("rate")),
        step=stretch, axis=np.arange(n) % 3, is_range=np.zeros(n, bool), x=np.zeros(A.shape[1]),
        columns_of=(np.zeros(0, np.int64), np.zeros(0, np.int64)), weights=(), excitation=excitation,
        noise_dof=NOISE_DOF,
    )  # fmt: skip


def _scatter(residual: FloatArray, triad: IntArray) -> FloatArray:
    """Return 1 sigma (n,) of rows by how much neighbouring windows differ, of each kind of rows."""
    sigma = np.ones(len(residual))
    for number in np.unique(triad):
        rows = triad == number
        apart = np.diff(residual[rows].reshape(-1, 3), axis=0)
        middle = float(np.median(np.abs(apart))) / MEDIAN_OF_NORMAL / np.sqrt(2)  # manoeuvres are not noise
        sigma[rows] = max(middle, np.finfo(float).tiny)
    return sigma


def _candidate(effect: AttitudeEffect, H: FloatArray, parameters: int) -> Candidate:
    known = Effect(effect.name, effect.unit, plausible=effect.plausible / FACTOR, separate_by=effect.separate_by)
    plausible = np.full(len(effect.coefficients), effect.plausible / FACTOR)  # here it is the most
    return Candidate(known, Columns(effect.coefficients), Term(H, plausible), np.zeros(parameters, bool))


NAMED = {each.name: each for each in ATTITUDE_EFFECTS}

"""The uncertainty budget of each parameter: variance split by source, degrees of freedom, coverage factor.

The parts are uncertain numbers of GTC (GUM Tree Calculator, Measurement Standards Laboratory of New Zealand).
Their sum has the combined uncertainty, and by Welch and Satterthwaite (JCGM 100:2008, G.4.1) the degrees of
freedom; the coverage factor is that of Student's distribution at them.
"""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.calibration.triad_calibration import (
    TriadVector,
    common_variance,
    moves_vector,
    scale_unit,
    triad_vector,
    vector_names,
)
from procedures.campaign.campaign import period_std
from procedures.statistics.least_squares import Fit
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.gyroscope_fit import (
    clock_on_accelerometer,
    clock_on_moves,
    clock_rows,
    latitude_rows,
)
from procedures.uncertainty import sources
from procedures.uncertainty.excess_scatter import (
    TemperatureEffect,
    accelerometer_columns,
    gyroscope_columns,
    moved_values,
    temperature_effect,
    unexplained,
    unexplained_within,
)
from procedures.uncertainty.row_variance import excess_cell, gyroscope_shares, joint_shares, moves_shares
from procedures.uncertainty.sources import (
    SOURCES,
    GivenValues,
    Shares,
    SourceCell,
    Unexplained,
    added_shares,
    type_of,
)
from procedures.units import DEG_H_PER_DEG_S

VARIANCE_ROUNDING = 1e-6  # of a variance: two ways to the same covariance differ by less


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """A triad's k (3), E (9), D (3) and, by cell, the part that each has in their variances (15,)."""

    vector: TriadVector
    variance: Shares


@dataclass(frozen=True, slots=True, eq=False)
class _FitGain:
    """A fit's gain (p, n) and the shares (n,) of its rows, with what the global test leaves unexplained."""

    gain: FloatArray
    shares: Shares
    temperature: TemperatureEffect | None


def gain_of(fit: Fit) -> FloatArray:
    """Return (p, n) by how much the parameters move with the whitened rows: ``P J'``, by the QR factors of J."""
    size = np.linalg.norm(fit.jacobian, axis=0)
    Q, R = np.linalg.qr(fit.jacobian / size)
    gain: FloatArray = np.linalg.solve(R, Q.T) / size[:, None]
    return gain


def decompose(fits: CampaignFits, inputs: GivenValues) -> dict[str, Decomposition]:
    """Split the variances of every triad that was solved, by ``accelerometer`` and ``gyroscope``."""
    found = dict[str, Decomposition]()
    inputs = replace(inputs, clock=float(np.hypot(inputs.clock, period_std(fits.campaigns))))
    chain = None
    if fits.accelerometer is not None:
        chain = _accelerometer_chain(fits.accelerometer, inputs)
        found["accelerometer"] = _accelerometer(fits, fits.accelerometer, chain, inputs)
    if fits.gyroscope is not None:
        found["gyroscope"] = _gyroscope(fits, chain, inputs)
    elif fits.moves is not None and chain is not None:
        found["gyroscope"] = _moves(fits, chain, inputs)
    return found


def _accelerometer_chain(joint: TriadFit, inputs: GivenValues) -> _FitGain:
    n = 3 * len(joint.seen.dwells)
    observed = np.zeros(len(joint.fit.residual), dtype=bool)
    observed[:n] = True
    if joint.rests is not None:
        observed[joint.rests.rows] = True
    effect = temperature_effect(joint.fit, accelerometer_columns(joint))
    extra = _unexplained("accelerometer", joint, observed, effect, inputs)
    return _FitGain(gain_of(joint.fit), added_shares(joint_shares(joint, "accelerometer"), extra), effect)


def _accelerometer(fits: CampaignFits, joint: TriadFit, chain: _FitGain, inputs: GivenValues) -> Decomposition:
    vector = triad_vector(joint, "accelerometer", joint)
    through = vector.jacobian @ chain.gain
    shift = clock_on_accelerometer(vector.value, fits.campaigns[0].counts) * inputs.clock
    variance = added_shares(
        _spread(through, chain.shares),
        _after_fit(vector, joint, "accelerometer", 1.0),
        _effects(vector, joint, through),
        _scale_left_open(vector, joint),
        {SourceCell(sources.CLOCK): shift**2},
        _temperature("accelerometer", through, chain.temperature),
        moved_values("accelerometer", inputs),
    )
    return Decomposition(vector, variance)


def _scale_left_open(vector: TriadVector, joint: TriadFit) -> Shares:
    """Return what squares of angles that rests near the faces do not determine add by the diagonal of K."""
    if joint.rests is None:
        return {}
    return {SourceCell(sources.SECOND_ORDER): vector.jacobian[:, [0, 4, 8]] ** 2 @ joint.rests.open_scale}


def _gyroscope(fits: CampaignFits, accelerometer: _FitGain | None, inputs: GivenValues) -> Decomposition:
    gyroscope = fits.gyroscope
    assert gyroscope is not None
    joint = gyroscope.joint
    given = fits.accelerometer is not None and not fits.accelerometer.is_turned_freely
    given &= gyroscope.moves is None  # with seats, the tilts are no longer the accelerometers' rows
    observations = 3 * (len(joint.seen.dwells) + len(gyroscope.turns))
    observed = np.arange(len(joint.fit.residual)) < observations
    effect = temperature_effect(joint.fit, gyroscope_columns(gyroscope))
    extra = _unexplained("gyroscope", joint, observed, effect, inputs)
    vector = triad_vector(joint, "gyroscope", fits.accelerometer)
    through = vector.jacobian @ gain_of(joint.fit)
    tilts: Shares = {}
    if given and accelerometer is not None:
        rows, shared = slice(observations, observations + joint.bench.shared), slice(12, 12 + joint.bench.shared)
        through_tilts = through[:, rows]
        onward = through_tilts @ joint.fit.jacobian[rows, shared] @ accelerometer.gain[shared]
        tilts = _by_origin(np.sum(through_tilts**2, axis=1), onward, accelerometer.shares)
    rate_output = not fits.campaigns[0].counts
    variance = added_shares(
        _spread(through, added_shares(gyroscope_shares(gyroscope, given), extra)),
        tilts,
        _after_fit(vector, joint, "gyroscope", DEG_H_PER_DEG_S),
        _effects(vector, joint, through),
        {SourceCell(sources.LATITUDE): (through @ latitude_rows(gyroscope) * inputs.latitude) ** 2},
        {SourceCell(sources.CLOCK): (through @ clock_rows(gyroscope, rate_output) * inputs.clock) ** 2},
        _temperature("gyroscope", through, effect),
        moved_values("gyroscope", inputs),
    )
    return Decomposition(vector, variance)


def _unexplained(
    triad: str, joint: TriadFit, observed: BoolArray, effect: TemperatureEffect | None, inputs: GivenValues
) -> Shares:
    left = (inputs.unexplained or {}).get(triad, Unexplained())
    among = unexplained(triad, joint.fit.chi2, joint.dof, observed, effect, inputs.unexplained is not None)
    return added_shares(among, unexplained_within(triad, joint, joint.dof, left.within))


def _moves(fits: CampaignFits, accelerometer: _FitGain, inputs: GivenValues) -> Decomposition:
    moves, joint = fits.moves, fits.accelerometer
    assert moves is not None
    assert joint is not None
    vector = moves_vector(moves, joint)
    shares, scatter = moves_shares(fits)
    extra = unexplained(
        "gyroscope", moves.fit.chi2, moves.fit.dof, np.ones(len(moves.fit.residual), dtype=bool), None,
        inputs.unexplained is not None,
    )  # fmt: skip
    through = vector.jacobian @ gain_of(moves.fit)[:12]
    onward = vector.jacobian @ moves.by_accelerometer @ accelerometer.gain[:12]
    own = np.sum(through**2, axis=1) + np.sum(onward**2, axis=1)
    common = np.maximum(np.diag(vector.covariance) - own, 0.0)
    shift = clock_on_moves(vector.value, fits.campaigns[0].counts) * inputs.clock
    variance = added_shares(
        _spread(through, added_shares(shares, extra)),
        _spread(onward, accelerometer.shares),
        {scatter: np.where(np.arange(15) < 12, 0.0, common)},
        {SourceCell(sources.CLOCK): shift**2},
    )
    return Decomposition(vector, variance)


def _spread(through: FloatArray, shares: Shares) -> Shares:
    return {cell: through**2 @ share for cell, share in shares.items()}


def _by_origin(total: FloatArray, onward: FloatArray, shares: Shares) -> Shares:
    """Split ``total`` (15,), what tilts taken from another fit add, as their origin there is split.

    The rows hold the tilts' covariance; what rounding and `gyroscope_model.TILT_FLOOR_RAD` add goes with the
    rest. What the other fit leaves unexplained comes on top.
    """
    size = np.sum(onward**2, axis=1)
    scale = np.divide(total, size, out=np.zeros_like(total), where=size > 0)
    return {cell: onward**2 @ share * scale for cell, share in shares.items()}


def _after_fit(vector: TriadVector, joint: TriadFit, triad: str, per: float) -> Shares:
    """Return what `triad_vector` adds to the fit's covariance: dwells' common, skew, second order."""
    of_bias = np.concatenate((np.zeros((3, 12)), common_variance(joint, vector.value[:3] / per)), axis=1)
    fitted = np.einsum("ip,pq,iq->i", vector.jacobian, joint.fit.covariance, vector.jacobian)
    skew = np.maximum(np.diag(vector.covariance) - fitted - of_bias.sum(axis=0) - vector.second, 0.0)
    skew[3:12] = 0.0  # E refers to the mean cube itself
    return {
        excess_cell(joint, triad): of_bias[0],
        SourceCell(sources.WARM_UP, triad): of_bias[1],
        SourceCell(sources.TURN_ON, triad, max(joint.profiled // 3, 1)): of_bias[2],
        SourceCell(sources.CUBE): skew,
        SourceCell(sources.SECOND_ORDER): vector.second,
    }


def _effects(vector: TriadVector, joint: TriadFit, through: FloatArray) -> Shares:
    """Return what the coefficients of effects leave open: the fit's covariance beyond that of its own rows."""
    fitted = np.einsum("ip,pq,iq->i", vector.jacobian, joint.fit.covariance, vector.jacobian)
    own = np.sum(through**2, axis=1) + sum(_scale_left_open(vector, joint).values())
    return {SourceCell(sources.EFFECTS): np.where(fitted > own * (1 + VARIANCE_ROUNDING), fitted - own, 0.0)}


def _temperature(triad: str, through: FloatArray, effect: TemperatureEffect | None) -> Shares:
    if effect is None:
        return {}
    return {SourceCell(sources.TEMPERATURE, triad, effect.dof): effect.variance(through)}


COVERAGE_PROBABILITY = 0.95
INFINITE_DOF_FROM = 1e6  # degrees of freedom from which on they are no different from infinitely many


@dataclass(frozen=True, slots=True)
class Contribution:
    """A source's part in a parameter: 1 sigma in the parameter's unit, type A or B, degrees of freedom."""

    source: str
    type: str
    std: float
    dof: float


@dataclass(frozen=True, slots=True)
class ParameterBudget:
    """A parameter, named as in `Solution.names`, in ``unit``; ``expanded`` is ``coverage_factor * std``."""

    name: str
    value: float
    unit: str
    std: float
    dof: float
    coverage_factor: float
    expanded: float
    contributions: tuple[Contribution, ...]


def budget(fits: CampaignFits, inputs: GivenValues = GivenValues()) -> tuple[ParameterBudget, ...]:  # noqa: B008
    """Return the budgets of k, E off its diagonal, and D of every triad that was solved."""
    counts, found = fits.campaigns[0].counts, list[ParameterBudget]()
    for triad, part in decompose(fits, inputs).items():
        for i, name in enumerate(part.vector.names):
            if name.split(".")[1] == "misalignment" and name[-1] == name[-2]:
                continue
            unit = (scale_unit(triad, counts), "1", part.vector.bias_unit)[0 if i < 3 else 1 if i < 12 else 2]
            parts = {cell: float(variance[i]) for cell, variance in part.variance.items()}
            found.append(combined_budget(name, float(part.vector.value[i]), unit, parts))
    return tuple(found)


def combined_budget(name: str, value: float, unit: str, parts: dict[SourceCell, float]) -> ParameterBudget:
    """Combine the variances of independent cells."""
    from GTC import dof, reporting, ureal  # takes half a second: only where a budget is asked for

    sources = {}
    for source in sorted({cell.source for cell in parts}, key=SOURCES.index):
        numbers = [
            ureal(0.0, np.sqrt(variance), cell.dof)
            for cell, variance in parts.items()
            if cell.source == source and variance > 0
        ]
        if numbers:
            sources[source] = sum(numbers[1:], numbers[0])
    total = sum(list(sources.values())[1:], next(iter(sources.values())))
    lines = [Contribution(s, type_of(s), float(one.u), _many(dof(one))) for s, one in sources.items()]
    std, freedom = float(total.u), _many(dof(total))
    factor = float(reporting.k_factor(freedom, round(100 * COVERAGE_PROBABILITY)))
    return ParameterBudget(name, value, unit, std, freedom, factor, factor * std, tuple(lines))


def _many(dof: float) -> float:
    return float(dof) if dof < INFINITE_DOF_FROM else float("inf")


def with_clock(solution: Solution, fits: CampaignFits, std: float) -> Solution:
    """Return the solution of these fits, its sigmas and covariance widened by a relative 1 sigma of the clock."""
    shifts = {triad: std * shift for triad, shift in _shifts(fits).items()}
    by_name = dict[str, float]()
    for triad, shift in shifts.items():
        by_name |= zip(vector_names(triad), shift.tolist(), strict=True)
    step = np.array([by_name.get(name, 0.0) for name in solution.names])
    return replace(
        solution,
        accelerometer=_wider(solution.accelerometer, shifts.get("accelerometer")),
        gyroscope=_wider(solution.gyroscope, shifts.get("gyroscope")),
        covariance=solution.covariance + np.outer(step, step),
    )


def _shifts(fits: CampaignFits) -> dict[str, FloatArray]:
    """Return by triad the change of k, E, D (15,) per relative error of the time base."""
    counts, found = fits.campaigns[0].counts, dict[str, FloatArray]()
    joint = fits.accelerometer
    if joint is not None:
        vector = triad_vector(joint, "accelerometer", joint)
        found["accelerometer"] = clock_on_accelerometer(vector.value, counts)
    if fits.gyroscope is not None:
        vector = triad_vector(fits.gyroscope.joint, "gyroscope", joint)
        rows = clock_rows(fits.gyroscope, not counts)
        found["gyroscope"] = vector.jacobian @ (gain_of(fits.gyroscope.joint.fit) @ rows)
    elif fits.moves is not None and joint is not None:
        found["gyroscope"] = clock_on_moves(moves_vector(fits.moves, joint).value, counts)
    return found


def _wider(triad: TriadCalibration | None, shift: FloatArray | None) -> TriadCalibration | None:
    return triad if triad is None or shift is None else triad.widened(shift)

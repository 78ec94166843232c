"""The loop closed: the parameters solved again with the adopted effects in the model.

What an effect adds is subtracted from every rate and total, the base model is fitted to what is left, and the
coefficients are solved again where that fit stands (Gauss-Newton). The parameters' covariance is that of the whole
model: it holds what the coefficients leave open.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps
from procedures.campaign.campaign import Campaign, MoveRecord
from procedures.campaign.observations import TriadRests
from procedures.counts.sample_records import CountSeries
from procedures.effects.effect import with_slope
from procedures.effects.excitation import LOG_RANGE, Columns, turned_columns
from procedures.errors import DoesNotFit
from procedures.evidence.candidates import Candidate, raising_does_not_fit
from procedures.evidence.linear_model import LinearFit, Term, fit_linear
from procedures.evidence.residual_rows import KINDS, Evidence, evidence_of
from procedures.evidence.row_sums import MoveWeights, move_bins
from procedures.frames import TRIADS
from procedures.twelve_positions.accelerometer_fit import TriadFit

Added = tuple[FloatArray | None, MoveWeights, FloatArray | None]


def without_in_moves(
    campaigns: Sequence[Campaign], evidence: Evidence, k: FloatArray, gyro: FloatArray | None,
    turned: FloatArray | None,
) -> tuple[Campaign, ...]:  # fmt: skip
    """Return campaigns whose moves are free of effects.

    Parameters
    ----------
    campaigns : with their moves as recorded
    evidence : whose nodes what is added holds at
    k : (3,) [output/deg], the gyroscopes' scale factors
    gyro : (n, 3) [deg/s], added to E u + D at the nodes, or None
    turned : (n, 3) [rad], by which all that is seen at the nodes is turned, or None
    """
    added = dict[tuple[int, str], Added]()
    for each in evidence.weights:
        if each.move is not None:
            step = evidence.excitation.steps[evidence.step[each.rows.start]]
            added[step.campaign, step.name] = (None if gyro is None else gyro[each.nodes], each.move, turned)
    return tuple(
        replace(
            campaign,
            moves=tuple(
                _less(one, k, *added[number, one.name]) if (number, one.name) in added else one
                for one in campaign.moves
            ),
        )
        for number, campaign in enumerate(campaigns)
    )


def _less(
    record: MoveRecord, k: FloatArray, gyro: FloatArray | None, weights: MoveWeights, turned: FloatArray | None
) -> MoveRecord:
    if turned is not None:
        off = np.radians(weights.of_ends(turned[:, :, None])[:, 0])
        record = replace(record, off=off)
    if gyro is None or record.series.gyro is None:
        return record
    series = record.series
    added = np.repeat(gyro * k, np.diff(move_bins(series).edges), axis=0)
    per_sample = series.period if isinstance(series, CountSeries) else 1.0
    less: Any = np.asarray(record.series.gyro) - added * per_sample  # of counts no whole numbers any more
    return replace(record, series=replace(series, gyro=less))


MAX_ITERATIONS = 10  # an effect that is nearly linear settles in three
ITERATIONS_WITH_GIVEN_VALUES = 3  # what an effect adds hangs on the fit by its misalignment alone
LARGEST_STEP = 1.0  # of a time constant's logarithm in one round
CONVERGED_SIGMAS = 1e-3  # sigma by which the last round still moved a coefficient
BASE_CONVERGED_SIGMAS = 0.05  # the same of a parameter of the base model, which follows

Model = TypeVar("Model")


@dataclass(frozen=True, slots=True, eq=False)
class Refit:
    """The fits with effects in, the evidence that is left of them, and the linear fit there.

    ``added`` are the effects, those with a time constant at what was fitted, ``values`` their coefficients (k,),
    in the order given. ``declared`` are those that `evidence` holds as parameters, with ``declared_values``.
    ``bare`` are the fits without what the coefficients leave open, where the base model is a campaign's fits.
    """

    fits: CampaignFits
    evidence: Evidence
    linear: LinearFit
    values: tuple[FloatArray, ...]
    added: tuple[Candidate, ...] = ()
    declared: tuple[Candidate, ...] = ()
    declared_values: tuple[FloatArray, ...] = ()
    bare: CampaignFits | None = None


def refit(steps: ReducedSteps, base: CampaignFits, added: Sequence[Candidate]) -> Refit:
    """Solve everything again with the candidates ``added`` to the model; those of the model itself are in it.

    Raises
    ------
    DoesNotFit
        If the model with them in it cannot be fitted. Without any it is the base's own.
    """
    added = [each for each in added if not each.is_of_model]

    without = partial(_fit_without, steps)
    with raising_does_not_fit(bool(added)):
        return iterate(base, evidence_of, without, _with_covariance, added)


def iterate(
    model: Model,
    evidence_of: Callable[[Model], Evidence],
    without: Callable[[Model, Evidence, Sequence[Candidate], Sequence[FloatArray]], Model],
    fits_of: Callable[[Model, Evidence, LinearFit], CampaignFits],
    added: Sequence[Candidate],
) -> Refit:
    """Find the coefficients of effects and the base model with them in turn, until they stay (Gauss-Newton).

    ``evidence_of`` gives a base model's evidence. ``without`` (model, evidence, effects, coefficients (k,) of each
    in its unit) fits the base model again to what the effects leave. ``fits_of`` gives the fits in the end. Time
    constants are moved with the coefficients; an effect's last coefficient, their logarithm's change, is zero.
    What would leave its range is held at the end of it, and the others are fitted there.
    """
    added = list(added)
    values = [np.zeros(len(each.columns.coefficients)) for each in added]
    for _ in range(MAX_ITERATIONS):
        evidence = evidence_of(model)
        terms, offsets = terms_at(evidence, added, values)
        evidence = beyond_linear(evidence, terms, values, offsets)
        linear, terms = _within_ranges(evidence, added, terms)
        found = [linear.coefficients(i) for i in range(len(terms))]
        moved = [
            float(np.max(np.abs(c - old) / np.sqrt(np.diag(C)), initial=0.0))
            for (c, C), old in zip(found, values, strict=True)
        ]
        added = [replace(each, term=term) for each, term in zip(added, terms, strict=True)]
        values = [c for c, _ in found]
        if max(moved, default=0.0) < CONVERGED_SIGMAS and _base_step(linear) < BASE_CONVERGED_SIGMAS:
            break
        pairs = [_with_nonlinear(each, c) for each, c in zip(added, values, strict=True)]
        added, values = [each for each, _ in pairs], [c for _, c in pairs]
        model = without(model, evidence, added, values)
    bare = model if isinstance(model, CampaignFits) else None
    return Refit(fits_of(model, evidence, linear), evidence, linear, tuple(values), tuple(added), bare=bare)


def _base_step(linear: LinearFit) -> float:
    """Return by how many sigmas the base model's parameters would still move, of the one that moves most."""
    size = len(linear.theta) - sum(linear.sizes)
    std = np.sqrt(np.diag(linear.covariance)[:size])
    return float(np.max(np.abs(linear.theta[:size]) / std, initial=0.0))


def _within_ranges(
    evidence: Evidence, added: Sequence[Candidate], terms: list[Term]
) -> tuple[LinearFit, list[Term]]:
    """Return the fit, and its terms without slopes of what stands at an end of its range and would go beyond."""
    while True:
        linear = fit_linear(evidence, terms)
        held = [
            _held(each, term, linear.coefficients(i)[0])
            for i, (each, term) in enumerate(zip(added, terms, strict=True))
        ]
        if all(one is other for one, other in zip(held, terms, strict=True)):
            return linear, terms
        terms = held


def _held(candidate: Candidate, term: Term, c: FloatArray) -> Term:
    """Return a term whose slopes are zero where coefficients ``c`` (k,) would take it beyond its ranges."""
    way, beyond = candidate.columns, np.zeros(len(c), dtype=bool)
    for i, (name, value) in enumerate(way.nonlinear.items(), len(c) - len(way.nonlinear)):
        low, high = candidate.effect.ranges.get(name, (0.0, np.inf))
        beyond[i] = (value <= low and c[i] < 0) or (value >= high and c[i] > 0)
    return replace(term, H=np.where(beyond, 0.0, term.H)) if term.H[:, beyond].any() else term


def _with_nonlinear(candidate: Candidate, c: FloatArray) -> tuple[Candidate, FloatArray]:
    """Return an effect at its new time constant or what else is not linear, and its coefficients (k,) there."""
    way = candidate.columns
    if not way.nonlinear:
        return candidate, c
    first, moved = len(c) - len(way.nonlinear), dict[str, float]()
    for (name, value), by in zip(way.nonlinear.items(), c[first:], strict=True):
        low, high = candidate.effect.ranges.get(name, (0.0, np.inf))
        moved[name] = float(np.clip(value * np.exp(np.clip(by, -LARGEST_STEP, LARGEST_STEP)), low, high))
    found = replace(candidate, columns=replace(way, nonlinear=moved))
    return found, np.append(c[:first], np.zeros(len(moved)))


def refit_with(
    steps: ReducedSteps, base: CampaignFits, added: Sequence[Candidate], values: Sequence[FloatArray]
) -> Refit:
    """Solve everything but the coefficients; raises as `refit`.

    These are ``values`` (k,) of each effect, in its unit, found elsewhere.
    """
    fits = base
    with raising_does_not_fit(bool(added)):
        for _ in range(ITERATIONS_WITH_GIVEN_VALUES if added else 0):
            fits = _fit_without(steps, fits, evidence_of(fits), added, values)
        evidence = evidence_of(fits)
        terms, beyond = terms_at(evidence, added, values)
        left = beyond_linear(evidence, terms, values, beyond)
        off = sum((term.H @ c for term, c in zip(terms, values, strict=True)), np.zeros(len(left.residual)))
        left = replace(left, residual=left.residual - off)
        return Refit(fits, left, fit_linear(left, []), ())


def columns_at(candidate: Candidate, evidence: Evidence) -> Columns:
    """Return a candidate's columns at another evidence's nodes; `DoesNotFit` where it does not act there."""
    if candidate.effect.at is not None:
        return candidate.effect.at(evidence.excitation, candidate.columns)
    for columns in candidate.effect.columns(evidence.excitation):
        if columns.where == candidate.columns.where and columns.shape == candidate.columns.shape:
            return columns
    raise DoesNotFit(f"{candidate.effect.name} no longer acts as {candidate.columns.where}")


def terms_at(
    evidence: Evidence, added: Sequence[Candidate], values: Sequence[FloatArray]
) -> tuple[list[Term], list[FloatArray]]:
    """Return every effect's columns at its coefficients, and what it adds beyond these times them (n,) [g, deg/s].

    ``values`` (k,) are each effect's coefficients, in its unit.
    """
    terms, beyond = list[Term](), list[FloatArray]()
    for candidate, c in zip(added, values, strict=True):
        columns = columns_at(candidate, evidence)
        exact, columns = _bent(candidate, columns, evidence, c)
        H = evidence.column(columns)
        ranges = candidate.term.plausible
        terms.append(Term(H, np.append(ranges, np.full(H.shape[1] - len(ranges), LOG_RANGE))))
        beyond.append(np.zeros(len(H)) if exact is None else evidence.column(exact)[:, 0] - H @ c)
    return terms, beyond


def _bent(
    candidate: Candidate, columns: Columns, evidence: Evidence, c: FloatArray
) -> tuple[Columns | None, Columns]:
    """Return what a non-linear effect adds at c, as one column, and its columns there."""
    if columns.nonlinear:
        return None, with_slope(candidate.effect, evidence.excitation, columns, c)
    if candidate.effect.is_turn and columns.rotation is not None and np.any(c):
        return turned_columns(evidence.excitation, columns, c)
    added = candidate.effect.added
    if added is None or not np.any(c):
        return None, columns
    total, change = added(evidence.excitation, c)
    if columns.accel is not None:
        return Columns(("",), accel=total[:, :, None]), replace(columns, accel=change)
    return Columns(("",), gyro=total[:, :, None]), replace(columns, gyro=change)


def beyond_linear(
    evidence: Evidence, terms: Sequence[Term], values: Sequence[FloatArray], beyond: Sequence[FloatArray]
) -> Evidence:
    """Return the residual as if only what is beyond linear had been subtracted.

    ``values`` (k,) are each effect's coefficients, in its unit; ``beyond`` (n,) [g, deg/s] is what each adds
    beyond its columns times them. Means, totals, norms and moves come from a fit to them without the whole effect,
    and so does what gyroscopes know by accelerometers; slopes and curvatures are as measured.
    """
    residual = evidence.residual.copy()
    taken_off = evidence.rows("mean", "turn", "norm", "rate", "move", "prior")
    for term, c, more in zip(terms, values, beyond, strict=True):
        residual += np.where(taken_off, term.H @ c, -more)
    return replace(evidence, residual=residual)


def _fit_without(
    steps: ReducedSteps,
    fits: CampaignFits,
    evidence: Evidence,
    added: Sequence[Candidate],
    values: Sequence[FloatArray],
) -> CampaignFits:
    """Fit the base model to the steps less what the effects added to them; it must be determined as with them."""
    off: dict[tuple[int, str], list[FloatArray]] = {}
    whole = summed([added_at_nodes(candidate, evidence, c) for candidate, c in zip(added, values, strict=True)])
    for each in evidence.weights:
        kind, s = KINDS[evidence.kind[each.rows.start]], whole[each.triad]
        off.setdefault((each.triad, kind), []).append(np.zeros(3) if s is None else each.w @ s[each.nodes])
    accel, gyro, rests, turns, campaigns = steps.accel, steps.gyro, steps.rests, steps.turns, steps.campaigns
    if fits.accelerometer is not None and accel is not None and (here := off.get((0, "mean"))):
        accel = replace(accel, rate=accel.rate - fits.accelerometer.k * np.array(here))
    if fits.accelerometer is not None and rests is not None and (here := off.get((0, "norm"))):
        rests = replace(rests, rate=rests.rate - fits.accelerometer.k * np.array(here))
    about_turns = steps.turn_rests
    if fits.accelerometer is not None and about_turns is not None and whole[0] is not None:
        about_turns = _without_in_rests(about_turns, evidence, fits.accelerometer.k[:, None] * whole[0].T)
    if gyro is not None and fits.gyroscope is not None:
        k = fits.gyroscope.joint.k
        gyro = replace(gyro, rate=gyro.rate - k * np.array(off[1, "mean"]))
        used = [id(turn.record) for turn in fits.gyroscope.turns]
        less = dict(zip(used, off.get((1, "turn"), []), strict=True))
        turns = tuple(replace(t, total=t.total - k * less.get(id(t.record), 0.0)) for t in turns)
        campaigns = without_in_moves(campaigns, evidence, k, *whole[1:])
    found = fit_reduced(replace(
        steps, campaigns=campaigns, accel=accel, gyro=gyro, rests=rests, turns=turns, turn_rests=about_turns
    ))  # fmt: skip
    for triad in TRIADS:
        if (getattr(found, triad) is None) != (getattr(fits, triad) is None):
            raise DoesNotFit(f"without the effects the {triad} is no longer determined")
    return found


def _without_in_rests(rests: TriadRests, evidence: Evidence, added: FloatArray) -> TriadRests:
    """Return the rests before and after turns free of what is ``added`` (3, n) [output/s] at the nodes.

    They are parts of the turns, whose tilt they determine.
    """
    seen, rate = evidence.excitation, rests.rate.copy()
    number = {(step.campaign, step.name): i for i, step in enumerate(seen.steps) if step.kind == "turn"}
    for row, (campaign, rest) in zip(rate, rests.rests, strict=True):
        if (step := number.get((campaign, rest.name))) is not None:
            nodes = seen.step == step
            row -= [np.interp(rest.series.t, seen.t[nodes], of_sensor[nodes]).mean() for of_sensor in added]
    return replace(rests, rate=rate)


AtNodes = tuple[FloatArray | None, FloatArray | None, FloatArray | None]
"""What is added at the nodes (n, 3) [g] and [deg/s], and the small rotations (n, 3) [rad] of all that is seen."""


def added_at_nodes(candidate: Candidate, evidence: Evidence, c: FloatArray) -> AtNodes:
    """Return what an effect with coefficients ``c`` (k,) adds at the nodes (n, 3) [g], [deg/s] and turns [rad]."""
    columns = columns_at(candidate, evidence)
    exact, _ = _bent(candidate, columns, evidence, c)
    if exact is not None:
        columns, c = exact, np.ones(1)
    accel, gyro, turned = (
        None if part is None else part @ c for part in (columns.accel, columns.gyro, columns.rotation)
    )
    return accel, gyro, turned


def summed(parts: Sequence[AtNodes]) -> AtNodes:
    """Return what several effects add together."""
    accel, gyro, turned = (
        sum(there[1:], there[0]) if (there := [each for each in of if each is not None]) else None
        for of in (zip(*parts, strict=True) if parts else [(), (), ()])
    )
    return accel, gyro, turned


def _with_covariance(fits: CampaignFits, evidence: Evidence, linear: LinearFit) -> CampaignFits:
    """Return the fits with what the coefficients leave open added to their parameters' covariance.

    With C the coefficients' covariance and S the change of the parameters with them, it is ``S C S'``.
    """
    if not linear.sizes:
        return fits
    accel, gyro = fits.accelerometer, fits.gyroscope
    first, second = evidence.columns_of
    if accel is not None:
        accel = _covered(accel, linear, first)
    if gyro is not None:
        gyro = replace(gyro, joint=_covered(gyro.joint, linear, second))
    return replace(fits, accelerometer=accel, gyroscope=gyro)


def _covered(joint: TriadFit, linear: LinearFit, columns: IntArray) -> TriadFit:
    coefficients = slice(len(linear.theta) - sum(linear.sizes), None)
    common = linear.covariance[columns][:, coefficients]
    added = common @ np.linalg.solve(linear.covariance[coefficients, coefficients], common.T)
    return replace(joint, fit=replace(joint.fit, covariance=joint.fit.covariance + added))

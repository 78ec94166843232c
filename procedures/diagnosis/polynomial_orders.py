"""Which order the polynomials of temperature have: the simplest that foretells what is left out as well as any.

For each sensor every order is tried. What it makes of blocks, dwells and rests left out in turn is compared with
what the best one makes of them, whose mean square is the noise: of orders that are worse by no more than a
coefficient of three sigma would bring, the least is taken. A polynomial that bends more than the data do costs
more where it is left out than it gains.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate, term_of
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import Term, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.temperature_polynomial import MAX_LAGGED_ORDER, MAX_ORDER
from procedures.errors import DoesNotFit
from procedures.frames import AXES

NOISE_SIGMAS = 3.0  # of a coefficient, within which it says nothing
NEIGHBOURS = 3  # blocks of a soak that are left out together
MAX_ROUNDS = 3  # of all effects in turn: the order of one depends on that of another


def settle_orders(state: LoopState) -> LoopState:
    """Return the loop with every polynomial at its order; as it was where the model with them does not fit."""
    for _ in range(MAX_ROUNDS):
        again = [_at_its_orders(state, each) for each in state.adopted]
        if all(new is old for new, old in zip(again, state.adopted, strict=True)):
            return state
        try:
            state = state.solved_with(again)
        except DoesNotFit:
            return state
    return state


def _at_its_orders(state: LoopState, adopted: AdoptedEffect) -> AdoptedEffect:
    candidate = adopted.candidate
    if not candidate.columns.orders:
        return adopted
    evidence, beside = state.now.evidence, state.beside(candidate)
    orders = list(candidate.columns.orders)
    left_out = _neighbours_together(evidence, left_out_groups(evidence))
    for sensor in range(len(AXES)):
        highest = MAX_LAGGED_ORDER if candidate.columns.tau_s else MAX_ORDER
        ways = [_of_orders(evidence, candidate, _with(orders, sensor, n)) for n in range(1, highest + 1)]
        errors = [_errors(evidence, way, beside, left_out, sensor) for way in ways]
        orders[sensor] = 1 + simplest(np.array(errors))
    if tuple(orders) == candidate.columns.orders:
        return adopted
    return replace(adopted, candidate=_of_orders(evidence, candidate, tuple(orders)))


def _neighbours_together(evidence: Evidence, left_out: Sequence[IntArray]) -> list[IntArray]:
    """Return the groups with the blocks of soaks by threes: a single one its neighbours foretell by any curve."""
    steps = evidence.excitation.steps
    is_soak = [evidence.is_data[rows[0]] and steps[evidence.step[rows[0]]].kind == "soak" for rows in left_out]
    soaks = [rows for rows, so in zip(left_out, is_soak, strict=True) if so]
    others = [rows for rows, so in zip(left_out, is_soak, strict=True) if not so]
    return others + [np.concatenate(soaks[i : i + NEIGHBOURS]) for i in range(0, len(soaks), NEIGHBOURS)]


def simplest(errors: FloatArray) -> int:
    """Return the first of models, by their squared errors (m, r) in rows left out, within noise of the best.

    The unit is any; a row that one of them cannot foretell is nan and counts for none. With the best one's mean
    square as variance, a coefficient of no use changes the sum by about 1.
    """
    told = np.isfinite(errors).all(axis=0)
    total = np.sum(errors[:, told], axis=1)
    if not np.any(total > 0):
        return 0
    return int(np.flatnonzero(told.sum() * (total / total.min() - 1) <= NOISE_SIGMAS**2)[0])


def _with(orders: Sequence[int], sensor: int, order: int) -> tuple[int, ...]:
    return (*orders[:sensor], order, *orders[sensor + 1 :])


def _of_orders(evidence: Evidence, candidate: Candidate, orders: tuple[int, ...]) -> Candidate:
    """Return a candidate with other orders; the slope by its time constant is left to the next fit."""
    effect = candidate.effect
    assert effect.at is not None
    columns = effect.at(evidence.excitation, replace(candidate.columns, orders=orders))
    return replace(candidate, columns=columns, term=term_of(evidence, effect, columns))


def _errors(
    evidence: Evidence, way: Candidate, beside: Sequence[Term], left_out: Sequence[IntArray], sensor: int
) -> FloatArray:
    """Return the squared errors (r,), in units of counting noise, of a sensor's rows where they are left out."""
    fit = way.fit(evidence, beside, np.ones(len(evidence.residual)))
    _, error = predict_left_out(evidence, fit, left_out)
    triad = int(way.effect.name.startswith("gyroscope"))
    own: FloatArray = error[(evidence.axis == sensor) & (evidence.triad == triad) & evidence.is_data]
    return own**2

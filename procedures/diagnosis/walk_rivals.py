"""Whether a bias that walks at random could be what a drift, a settling, a jump or a scatter is taken for.

A walk of one variance steps between any two places, and within rests, in each of a triad's sensors or in one. It
is compared by marginal likelihood in the place of a finding; and it stands beside one, of the size that what is
left has: a walk goes somewhere, and by how far it may have gone a drift is no drift.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import MAX_LOG_P, AdoptedEffect
from procedures.diagnosis.linear_model import Term, fit_linear, significance
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.random_walk import walk_columns
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.scatter import MIN_MARGIN, likeliest, likeliest_gain, marginal_gain
from procedures.effects.effect import Effect
from procedures.frames import AXES, TRIADS

DRIFTS = (".bias_drift", ".bias_settling")
BY_TIME = (*DRIFTS, ".jump", "placement.tilt")
SMALLEST_STEP = 0.01  # sigma of a row, from which on the size of a walk is sought
PARTS = 4  # of a rest, before each of which a walk steps


def walk_outdoes(state: LoopState, one: AdoptedEffect) -> float:
    """Return by how much a random walk is likelier than what goes by time and a scatter beside it [ln likelihood].

    The ways of an effect count, and the sensors of which one alone may walk, where that is likelier than
    the finding: less far a walk of one is no better told than a drift of one.
    """
    candidate, evidence = one.candidate, state.now.evidence
    if not candidate.effect.name.endswith(BY_TIME):
        return -np.inf
    kept = [each for each in state.adopted if each is not one and not each.candidate.is_of_model]
    scatters = [each.candidate for each in kept if each.candidate.effect.is_scatter]
    beside = [each.term for each in kept if not each.candidate.effect.is_scatter]
    before = fit_linear(evidence, beside, factor=np.ones(len(evidence.residual)))
    walks = [likeliest_gain(evidence, before, H) for H in _walks(evidence, candidate)]
    if not walks:
        return -np.inf
    ways = max(len(state.pool.get(candidate.effect.name, ())), 1)
    named = marginal_gain(evidence, candidate, beside) - float(np.log(ways))
    for scatter in scatters:
        named += marginal_gain(evidence, scatter, [*beside, one.term])
    alone = max(walks[1:]) - float(np.log(len(walks) - 1)) - named
    return max(walks[0] - named, alone if alone > 0 else -np.inf)


def lost_in_a_walk(state: LoopState, one: AdoptedEffect) -> bool:
    """Say whether what goes by time is no longer seen beside a walk of the size that what it leaves has.

    Where nothing that it leaves walks, it is seen as before. A jump is a step of a walk: beside one it is none.
    """
    candidate, evidence = one.candidate, state.now.evidence
    if not candidate.effect.name.endswith(DRIFTS):
        return False
    as_is, beside = np.ones(len(evidence.residual)), state.beside(candidate)
    found = fit_linear(evidence, [*beside, one.term], factor=as_is)
    ways = len(state.pool) * max(len(state.pool.get(candidate.effect.name, ())), 1)
    for H in _walks(evidence, candidate):
        size, gain = likeliest(evidence, found, H)
        if gain > MIN_MARGIN:
            walk = Term(H, np.full(H.shape[1], size))
            test = significance(evidence, fit_linear(evidence, [*beside, walk, one.term], factor=as_is))
            if test.log_p + np.log(ways) > MAX_LOG_P:
                return True
    return False


def walk_in_place_of(state: LoopState, scatter: AdoptedEffect) -> float:
    """Return by how much a random walk of a triad's biases is likelier than a scatter [ln likelihood].

    Beside a jump, which takes the walk's largest step, a scatter of seats is what the others look like.
    """
    evidence, beside = state.now.evidence, state.beside(scatter.candidate)
    before = scatter.candidate.without(evidence, beside, np.ones(len(evidence.residual)))
    walks = [H for triad in TRIADS if (H := steps_of_a_walk(evidence, triad)).shape[1]]
    most = max((likeliest_gain(evidence, before, H) for H in walks), default=-np.inf)
    return most - marginal_gain(evidence, scatter.candidate, beside)


def triad_of(effect: Effect) -> str:
    """Return the triad in which an effect by time shows: a tilt in the accelerometers."""
    owner = effect.name.partition(".")[0]
    return owner if owner in TRIADS else "accelerometer"


def _walks(evidence: Evidence, candidate: Candidate) -> Iterator[FloatArray]:
    """Yield the columns (n, k) of a walk of an effect's triad, and of each of its sensors alone."""
    H = steps_of_a_walk(evidence, triad_of(candidate.effect))
    if H.shape[1]:
        yield H
        yield from (H[:, i :: len(AXES)] for i in range(len(AXES)))


@lru_cache(maxsize=4)
def steps_of_a_walk(evidence: Evidence, triad: str) -> FloatArray:
    """Return a walk's columns (n, k), of which a unit does a hundredth of a sigma of the row it moves most."""
    H = walk_columns(evidence, triad, PARTS)
    size = np.abs(H / evidence.sigma[:, None])
    return SMALLEST_STEP * H / float(size.max()) if size.any() else H[:, :0]

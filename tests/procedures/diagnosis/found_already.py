"""Where a diagnosis stands that has found some effects of a simulated unit, its rows drawn anew."""

from functools import cache

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.reduced_steps import reduce_steps
from procedures.diagnosis import effect_selection
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.linear_model import fit_linear, significance
from procedures.diagnosis.model_with_effects import BenchModel, LoopState
from procedures.diagnosis.refit import Refit
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Finding
from procedures.effects import EFFECTS
from tests.procedures.diagnosis.redrawn import redrawn, seen_by


@cache
def bench() -> BenchModel:
    """Return the model of the unit as it was solved."""
    fits, _, _ = seen_by("plain")
    return BenchModel(reduce_steps(fits.campaigns), fits)


def adopted(evidence: Evidence, way: Candidate) -> AdoptedEffect:
    """Return an effect as it entered the model."""
    test = significance(evidence, way.fit(evidence))
    return AdoptedEffect(way, effect_selection.TestedEffect(way, test, test.log_p), 10.0)


def stands(does: FloatArray | float, *ways: Candidate, seed: int = 1) -> LoopState:
    """Return the state with effects found in rows of noise and what ``does`` (n,) adds to them."""
    fits, base, pool = seen_by("plain")
    evidence = redrawn(base, np.random.default_rng(seed), does)
    now = Refit(fits, evidence, fit_linear(evidence, []), ())
    return LoopState(bench(), EFFECTS, tuple(adopted(evidence, way) for way in ways), now, pool)


def ways_of(name: str) -> list[Candidate]:
    """Return the ways in which an effect may have acted."""
    return list(seen_by("plain")[2][name])


def finding(one: AdoptedEffect, confidence: str = "likely", share: float = 1.0) -> Finding:
    """Return an effect as it is told."""
    value, covariance = one.candidate.fit(seen_by("plain")[1]).coefficients()
    return Finding(
        one.candidate.effect.name, one.candidate.effect.kind, one.candidate.columns.coefficients, value,
        np.sqrt(np.diag(covariance)), "g", {}, confidence, (), "", -20.0, 10.0, share=share,  # type: ignore[arg-type]
    )  # fmt: skip

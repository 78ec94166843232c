"""Evidence to draw anew: of a simulated unit, and a small one made up of numbers alone."""

from dataclasses import replace
from functools import cache

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation, ExcitationStep
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.linear_model import Term
from procedures.evidence.residual_rows import KINDS, Evidence, evidence_of
from tests.benchmarks.diagnosing.designs import DESIGNS, unit


@cache
def seen_by(design: str, seed: int = 1) -> tuple[CampaignFits, Evidence, Candidates]:
    """Return the fits of a unit with nothing planted, their evidence, and what it can speak of."""
    made = DESIGNS[design]
    fits = fit(made.make(unit(seed, **made.truth), seed))
    evidence = evidence_of(fits)
    return fits, evidence, Candidates(evidence, fits, EFFECTS)


def redrawn(evidence: Evidence, rng: np.random.Generator, added: FloatArray | float = 0.0) -> Evidence:
    """Return the evidence with noise of its own sigma in every row, and ``added`` (n,)."""
    return replace(evidence, residual=rng.standard_normal(len(evidence.sigma)) * evidence.sigma + added)


def small(rng: np.random.Generator, parameters: int = 9) -> Evidence:
    """Return twelve dwells of three rows of unit noise, under a model of random columns."""
    n = 36
    steps = tuple(ExcitationStep(f"dwell_{i}", "dwell", 0, i + 1, "") for i in range(12))
    nothing, vectors = np.zeros(0), np.zeros((0, 3))
    seen = Excitation(
        vectors, vectors, vectors, vectors, vectors, vectors, nothing, nothing, nothing, nothing, {},
        np.zeros(0, dtype=np.int64), *np.zeros((3, 0, 3, 3)), steps,
    )  # fmt: skip
    zeros = np.zeros(n, dtype=np.int64)
    return Evidence(
        rng.standard_normal(n), np.ones(n), rng.standard_normal((n, parameters)), zeros,
        zeros + KINDS.index("mean"), np.repeat(np.arange(12), 3), np.tile(np.arange(3), 12),
        np.zeros(n, dtype=bool), np.zeros(parameters), (np.arange(parameters), zeros[:0]), (), seen,
    )  # fmt: skip


def made_up(
    evidence: Evidence, H: FloatArray, name: str = "accelerometer.made_up", size: float = 100
) -> Candidate:
    """Return a candidate of columns H (n, k), of a plausible ``size``."""
    keys = tuple(str(i) for i in range(H.shape[1]))
    effect = Effect(name, "1", "", "", size, lambda seen: [], "")
    nothing = np.zeros(len(evidence.x), dtype=bool)
    return Candidate(effect, Columns(keys), Term(H, np.full(len(keys), size)), nothing)

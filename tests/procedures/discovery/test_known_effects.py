"""What the catalogue has, or what is in doubt already, is given no new name; what neither explains is new."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery.factors import Factor
from procedures.discovery.finalists import Finalist, sized
from procedures.discovery.known_effects import is_known
from procedures.discovery.library import LibraryTerm
from procedures.discovery.search import gain_of
from procedures.effects import EFFECTS
from tests.procedures.diagnosis.redrawn import made_up, redrawn, seen_by

TERM = LibraryTerm("accelerometer", ((Factor("f", "g"),),))


def along(seed: int) -> FloatArray:
    """Return a column that no effect is, of a sigma a row."""
    _, evidence, _ = seen_by("plain")
    h = np.random.default_rng(seed).standard_normal((len(evidence.sigma), 1)) * evidence.sigma[:, None]
    h[~evidence.is_data] = 0.0
    return h


def said(
    evidence: Evidence,
    H: FloatArray,
    names: Sequence[str] = (),
    doubtful: Sequence[Candidate] = (),
    tried: int = 1,
) -> bool:
    """Say whether it is known what columns do that were found, to a catalogue of these names."""
    fits, _, _ = seen_by("plain")
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    best = Finalist(TERM, sized(evidence, fit, H), np.zeros(len(evidence.x)), gain_of(evidence, fit, H), 1.0)
    pool = Candidates(evidence, fits, [each for each in EFFECTS if each.name in names])
    return is_known(evidence, fit, [], best, pool, doubtful, left_out_groups(evidence), tried)


def planted(does: FloatArray) -> Evidence:
    _, base, _ = seen_by("plain")
    return redrawn(base, np.random.default_rng(3), does)


@pytest.mark.parametrize(
    ("doubtful", "known"), [((), False), ((1,), True), ((2,), False), ((2, 1), True), ((2, 4), False)]
)
def test_what_is_in_doubt_already_is_not_new_where_it_explains_as_much(
    doubtful: tuple[int, ...], known: bool
) -> None:
    evidence = planted(along(1)[:, 0])
    ways = [made_up(evidence, along(seed)) for seed in doubtful]
    assert said(evidence, along(1), (), ways) == known


@pytest.mark.parametrize(
    ("catalogue", "known"),
    [(("accelerometer.quadratic",), True), ((), False), (("gyroscope.g_sensitivity",), False)],
)
def test_an_effect_of_the_catalogue_is_known_by_its_own_name(catalogue: tuple[str, ...], known: bool) -> None:
    _, _, pool = seen_by("plain")
    H = pool["accelerometer.quadratic"][0].term.H
    assert said(planted(1e-4 * H[:, 0]), H[:, :1], catalogue) == known

"""The library is what its texts say, noise finds nothing in it, and what is planted is found."""

from functools import cache

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.discovery.discover import discover
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.effects.excitation import Columns, per_axis
from procedures.evidence.residual_rows import Evidence, evidence_of
from tests.benchmarks.discovering.judged import similarity
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.discovering.planting import Drawn, bare_evidence, size_of
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.procedures.diagnosis.test_move_rows import seen

SEED = 11


@cache
def searched() -> tuple[Evidence, list[LibraryTerm], Rows]:
    evidence = bare_evidence(campaigns_of(truth_of("warm", SEED), "warm", SEED).campaigns)
    return evidence, library(evidence.excitation), Rows(evidence)


def test_the_rows_of_a_term_are_those_that_its_text_makes() -> None:
    evidence, terms, rows = searched()
    for term in terms[::211]:
        effect = term.as_effect("a", 1.0, "")
        shape = {name: one.value for name, one in term.shape.items()}
        way = effect.at(evidence.excitation, Columns((), nonlinear=shape))
        linear = len(way.coefficients) - len(shape)
        expected = evidence.column(way)[:, :linear] / evidence.sigma[:, None]
        m = len(term.products)  # the text's coefficients go sensor by sensor, the library's product by product
        found = rows.of([term])[:, 0].reshape(-1, m, 3).transpose(0, 2, 1).reshape(len(expected), -1)
        for a, b in zip(found.T, expected.T, strict=True):
            size = np.linalg.norm(a) * np.linalg.norm(b)
            assert size == 0 or a @ b / size > 1 - 1e-9, term.texts


def test_a_law_that_no_catalogue_holds_is_proposed() -> None:
    law = next(law for law in LAWS if law.name == "temperature times its rate")
    truth, drawn = truth_of(law.design, SEED), Drawn.of(law, SEED)
    bare = bare_evidence(campaigns_of(truth, law.design, SEED).campaigns)
    also = drawn.planted(1.5 * size_of(drawn, bare, SEED), np.array(truth.magnetic_enu_ut))
    found = diagnose(campaigns_of(truth, law.design, SEED, also, stated=truth).campaigns)
    more = discover(found)
    (one,) = more.proposals
    does = drawn.done(more.evidence)
    assert max(similarity(more.evidence, [each], does) for each in one.columns) > 0.98
    assert one.probability > 0.9
    assert one.held_out[1] < one.held_out[0]
    assert one.share > 0.5


def test_a_good_bench_has_nothing_proposed() -> None:
    found = diagnose(campaigns_of(truth_of("plain", SEED), "plain", SEED).campaigns)
    assert discover(found).proposals == ()


@pytest.mark.proof
def test_a_bend_of_the_fast_turns_leaves_the_scale_factor_of_the_slow_ones() -> None:
    """Of sensors that gain above a knee, and one that loses, it is no loss of counts that the catalogue has."""
    law, seed = next(law for law in LAWS if law.name == "counts lost"), 409_000
    truth, drawn = truth_of(law.design, seed), Drawn.of(law, seed)
    size = size_of(drawn, bare_evidence(campaigns_of(truth, law.design, seed).campaigns), seed)
    also = drawn.planted(size, np.array(truth.magnetic_enu_ut))
    (one,) = discover(diagnose(campaigns_of(truth, law.design, seed, also, stated=truth).campaigns)).proposals
    assert one.term.terms == ("sign(u) * max(0, abs(u) - w)",)
    assert abs(one.value[-1] - 25) < 4 * one.std[-1]
    assert min(one.value[:3]) < 0 < max(one.value[:3])


# Terms in moves


def test_a_term_of_the_library_turns_moves_as_an_effects_columns_do() -> None:
    _, fits, _ = seen()
    evidence = evidence_of(fits)
    term = next(
        each
        for each in library(evidence.excitation, ["gyroscope"])
        if each.texts == ("f",) or each.texts == ("u",)
    )
    value = evidence.excitation.f if term.texts == ("f",) else evidence.excitation.omega
    H = evidence.column(Columns(("x", "y", "z"), gyro=per_axis(value))) / evidence.sigma[:, None]
    np.testing.assert_allclose(Rows(evidence).of([term])[:, 0], H, rtol=1e-9, atol=1e-9)
    assert np.abs(H[evidence.rows("move")]).max() > 0

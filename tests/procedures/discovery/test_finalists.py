"""What a term's columns may do, how likely they make the data, and which terms come into question."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import finalists as module
from procedures.discovery.finalists import at, finalists, likelier
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.discovery.search import Scores, blocks_of, gain_of, scores
from tests.procedures.diagnosis.redrawn import redrawn, seen_by


def bare(evidence: Evidence, others: Sequence[Term] = ()) -> LinearFit:
    return fit_linear(evidence, others, factor=np.ones(len(evidence.residual)))


def searched(seed: int) -> tuple[Rows, LinearFit, list[LibraryTerm], Scores, int]:
    """Return a few terms over noise with one of them planted."""
    _, base, _ = seen_by("plain")
    terms = [each for each in library(base.excitation, ["accelerometer"]) if len(each.products) == 1][:60]
    one = [each.texts for each in terms].index(("u * f_before",))
    W = Rows(base).of([terms[one]])
    does = W.reshape(len(W), -1).sum(axis=1)
    planted = 60 * does / np.linalg.norm(does - bare(base).Q @ (bare(base).Q.T @ does)) * base.sigma
    evidence = redrawn(base, np.random.default_rng(seed), planted)
    rows, fit = Rows(evidence), bare(evidence)
    return rows, fit, terms, scores(fit, blocks_of(rows, terms), np.inf), one


def test_the_planted_term_comes_into_question_and_the_likeliest_is_first() -> None:
    rows, fit, terms, found, one = searched(1)
    ranked = finalists(rows, fit, [], terms, found, [])
    assert terms[one].key in {each.term.key for each in ranked}
    assert [each.density for each in ranked] == sorted((each.density for each in ranked), reverse=True)
    assert len({each.term.key for each in ranked}) == len(ranked)
    most = float(found.gain.max())
    gains = {terms[i].key: float(found.gain[i]) for i in range(len(terms))}
    for each in ranked:
        assert gains[each.term.key] >= module.MIN_SHARE * most
        assert each.gain == pytest.approx(gains[each.term.key], rel=1e-2)
        assert each.gain == pytest.approx(float(each.does @ each.does), rel=1e-4)
        cost = 2 * (each.term.weight - 1)
        assert each.density == pytest.approx(likelier(rows.evidence, fit, each.columns) - cost)


@pytest.mark.parametrize("place", [0.3, 0.6])
def test_a_parameter_is_fitted_where_the_term_explains_most(place: float) -> None:
    """Planted between the values of the grid, with three sensors alike."""
    _, base, _ = seen_by("plain")
    term = next(each for each in library(base.excitation, ["accelerometer"]) if len(each.shape) == 1)
    ((name, shape),) = term.shape.items()
    true = float(np.exp(np.log(shape.low) + place * np.log(shape.high / shape.low)))
    W = Rows(base).of([at(term, name, true)])
    does = W.reshape(len(W), -1).sum(axis=1)
    fit = bare(base)
    left = does - fit.Q[: len(does)] @ (fit.Q[: len(does)].T @ does)
    evidence = redrawn(base, np.random.default_rng(1), 3000 * does / np.linalg.norm(left) * base.sigma)
    rows, fit = Rows(evidence), bare(evidence)
    found = scores(fit, blocks_of(rows, [term]), np.inf)
    (one,) = finalists(rows, fit, [], [term], found, [])
    assert one.term.shape[name].value == pytest.approx(true, rel=0.05)
    assert one.gain >= float(found.gain[0]) * 0.999
    fitted = rows.of([one.term]).reshape(len(W), -1) * evidence.sigma[:, None]
    assert one.columns.H == pytest.approx(fitted)
    assert np.linalg.norm(one.does) == pytest.approx(3000, rel=0.02)


def test_what_a_term_does_is_in_the_units_of_the_rows() -> None:
    rows, fit, terms, found, _ = searched(3)
    for each in finalists(rows, fit, [], terms, found, []):
        whole = rows.of([each.term]).reshape(len(rows.evidence.sigma), -1) * rows.evidence.sigma[:, None]
        kept = [i for i in range(whole.shape[1]) if gain_of(rows.evidence, fit, whole[:, [i]]) > 0]
        assert each.columns.H == pytest.approx(whole[:, kept])

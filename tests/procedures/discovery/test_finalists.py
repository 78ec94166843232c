"""What a term's columns may do, how likely they make the data, and which terms come into question."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import finalists as module
from procedures.discovery.finalists import finalists, likelier
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.discovery.search import Scores, blocks_of, scores
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

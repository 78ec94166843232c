"""What a term's columns may do, how likely they make the data, and which terms come into question."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import finalists as module
from procedures.discovery.factors import Factor, Shape
from procedures.discovery.finalists import Finalist, at, candidate, finalists, held_out, likelier, sized
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.discovery.search import Scores, blocks_of, gain_of, scores
from tests.procedures.diagnosis.redrawn import redrawn, seen_by, small

N = 36
LEFT_OUT = [np.arange(i, i + 9) for i in range(0, N, 9)]
PLAIN = LibraryTerm("accelerometer", ((Factor("f", "g"),),))
BENT = LibraryTerm(
    "gyroscope", ((Factor("u"), Factor("exp(-(u / w)**4)", shape={"w": Shape("deg/s", 3.0, 1.0, 9.0)})),),
    {"w": Shape("deg/s", 3.0, 1.0, 9.0)},
)  # fmt: skip


def bare(evidence: Evidence, others: Sequence[Term] = ()) -> LinearFit:
    return fit_linear(evidence, others, factor=np.ones(len(evidence.residual)))


def columns(seed: int, k: int = 1) -> FloatArray:
    return np.random.default_rng(seed).standard_normal((N, k))


def beside_model(evidence: Evidence, H: FloatArray) -> FloatArray:
    Q, _ = np.linalg.qr(evidence.A)
    return H - Q @ (Q.T @ H)


@pytest.mark.parametrize("sigma", [1.0, 0.5])
@pytest.mark.parametrize(("planted", "is_more"), [(0.0, False), (-40.0, True), (40.0, True)])
def test_a_coefficient_may_do_ten_sigmas_or_as_much_as_it_does(
    planted: float, is_more: bool, sigma: float
) -> None:
    evidence = small(np.random.default_rng(1))
    object.__setattr__(evidence, "sigma", np.full(N, sigma))
    h = columns(2)
    left = beside_model(evidence, h)[:, 0]
    evidence.residual[:] += planted * sigma * h[:, 0] / np.linalg.norm(left)
    term = sized(evidence, bare(evidence), h)
    found = abs(left @ evidence.residual) / (left @ left)
    assert term.plausible == pytest.approx([found if is_more else 10 * sigma / np.linalg.norm(left)])
    assert np.array_equal(term.H, h)


def test_a_column_that_does_nothing_beside_the_model_is_no_error() -> None:
    evidence = small(np.random.default_rng(1))
    assert np.all(sized(evidence, bare(evidence), np.zeros((N, 2))).plausible > 1e100)


@pytest.mark.parametrize("plausible", [0.2, 3.0])
@pytest.mark.parametrize("sigma", [1.0, 2.0])
def test_a_term_is_likelier_by_what_draws_of_its_range_explain(plausible: float, sigma: float) -> None:
    evidence = small(np.random.default_rng(3))
    object.__setattr__(evidence, "sigma", np.full(N, sigma))
    h = columns(4)
    left = beside_model(evidence, h)[:, 0] / sigma
    z = left @ evidence.residual / sigma / np.linalg.norm(left)
    s2 = (plausible * np.linalg.norm(left)) ** 2
    found = likelier(evidence, bare(evidence), Term(h, np.array([plausible])))
    assert found == pytest.approx(0.5 * (z**2 * s2 / (1 + s2) - np.log(1 + s2)))


def test_two_columns_of_which_neither_knows_the_other_are_likelier_by_the_sum() -> None:
    evidence = small(np.random.default_rng(5))
    Q, _ = np.linalg.qr(beside_model(evidence, columns(6, 2)))
    fit, each = bare(evidence), np.ones(1)
    both = likelier(evidence, fit, Term(Q, np.ones(2)))
    assert both == pytest.approx(sum(likelier(evidence, fit, Term(Q[:, [i]], each)) for i in range(2)))


def test_beside_another_term_what_it_explains_does_not_count_again() -> None:
    evidence = small(np.random.default_rng(7))
    h = columns(8)
    evidence.residual[:] += 20 * h[:, 0]
    other = Term(h, np.full(1, 1e6))
    assert likelier(evidence, bare(evidence, [other]), Term(h, np.ones(1))) == pytest.approx(0.0, abs=1e-3)
    assert likelier(evidence, bare(evidence), Term(h, np.ones(1))) > 100


def test_rows_left_out_gain_by_a_term_what_they_are_foretold_better() -> None:
    evidence, other = small(np.random.default_rng(9)), Term(columns(10), np.ones(1))
    term = Term(columns(11), np.ones(1))
    evidence.residual[:] += 2 * term.H[:, 0]
    gained = held_out(evidence, [other], LEFT_OUT)
    before, after = (
        predict_left_out(evidence, bare(evidence, terms), LEFT_OUT)[0] for terms in ([other], [other, term])
    )
    assert gained(term) == pytest.approx(after - before)
    assert gained(term) > 5
    assert gained(Term(np.zeros((N, 1)), np.ones(1))) == pytest.approx(0.0, abs=1e-9)


def finalist(does: Sequence[float], term: LibraryTerm = PLAIN, k: int = 2) -> Finalist:
    return Finalist(term, Term(columns(12, k), np.arange(1.0, k + 1)), np.array(does), 1.0, 2.0)


@pytest.mark.parametrize(
    ("does", "other", "likeness"),
    [([3, 4], [3, 4], 1.0), ([3, 4], [-6, -8], -1.0), ([3, 4], [4, -3], 0.0), ([3, 4], [0, 2], 0.8),
     ([0, 0], [1, 1], 0.0), ([1, 1], [0, 0], 0.0)],
)  # fmt: skip
def test_likeness_is_a_correlation(does: list[float], other: list[float], likeness: float) -> None:
    assert finalist(does).likeness(np.array(other, dtype=float)) == pytest.approx(likeness)


def test_a_parameter_is_put_where_it_stands_and_nowhere_else() -> None:
    moved = at(BENT, "w", 5.0)
    assert moved.shape["w"] == Shape("deg/s", 5.0, 1.0, 9.0)
    assert [dict(factor.shape) for factor in moved.products[0]] == [{}, dict(moved.shape)]
    assert (moved.key, BENT.shape["w"].value) == (BENT.key, 3.0)


def test_a_finalist_is_tested_as_an_effect_that_is_not_in_the_model() -> None:
    evidence = small(np.random.default_rng(13))
    way = candidate(evidence, finalist([1, 2], k=3))
    assert way.columns.coefficients == ("0", "1", "2")
    assert way.term.H.shape == (N, 3)
    assert way.taken.shape == (9,)
    assert not way.is_of_model


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


def test_no_more_terms_are_looked_at_than_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, fit, terms, found, _ = searched(2)
    every = finalists(rows, fit, [], terms, found, [])
    assert len(every) > 1
    monkeypatch.setattr(module, "MOST", 1)
    assert len(finalists(rows, fit, [], terms, found, [])) == 1


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

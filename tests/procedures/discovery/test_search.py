"""The library is what its texts say, noise finds nothing in it, and what is planted is found."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2

from procedures.diagnosis.candidates import Candidate, term_of
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import search
from procedures.discovery.discover import discover
from procedures.discovery.factors import inputs_seen
from procedures.discovery.known_effects import fitted_way
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.discovery.search import blocks_of, scores
from procedures.effects import EFFECTS
from procedures.effects.effect import Columns
from tests.benchmarks.discovering.judged import likeness
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.discovering.planting import Drawn, bare_evidence, size_of
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of

SEED = 11


@cache
def searched() -> tuple[Evidence, list[LibraryTerm], Rows]:
    evidence = bare_evidence(campaigns_of(truth_of("warm", SEED), "warm", SEED).campaigns)
    return evidence, library(evidence.excitation), Rows(evidence)


def test_what_never_changes_is_no_input_of_a_law() -> None:
    evidence, _, _ = searched()
    seen = evidence.excitation
    names = {one.text for one in inputs_seen(seen, "accelerometer")}
    still = replace(seen, auxiliary={"still": np.ones(len(seen.t)), "moves": np.arange(len(seen.t), dtype=float)})
    assert {one.text for one in inputs_seen(still, "accelerometer")} - names == {"aux_moves"}


def test_ten_thousand_terms_are_in_the_grammar_each_once_but_for_its_parameter() -> None:
    _, terms, _ = searched()
    assert len(terms) > 9000
    assert all(term.as_effect("a", 1.0, "") for term in terms[::17])
    told = {(term.key, tuple(one.value for one in term.shape.values())) for term in terms}
    assert len(told) == len(terms)


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


@cache
def p_of_noise() -> list[float]:
    """Return p over the library of residuals of noise drawn here, by another generator."""
    evidence, terms, rows = searched()
    blocks = blocks_of(rows, terms[::12])
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    rng, p = np.random.default_rng(5), list[float]()
    for _ in range(40):
        z = rng.standard_normal(len(fit.whole))
        z -= fit.Q @ (fit.Q.T @ z)
        object.__setattr__(fit, "whole", z)
        found = scores(fit, blocks, evidence.noise_dof)
        p.append(found.family_p(int(np.argmin(found.log_p))))
    return p


def test_noise_alone_is_seen_as_often_as_the_level_says() -> None:
    """It is even, not 1 in 400."""
    p = p_of_noise()
    assert 0.25 < np.mean(p) < 0.75
    assert np.sum(np.array(p) < 0.05) <= 8


def test_a_law_that_no_catalogue_holds_is_proposed() -> None:
    law = next(law for law in LAWS if law.name == "temperature times its rate")
    truth, drawn = truth_of(law.design, SEED), Drawn.of(law, SEED)
    bare = bare_evidence(campaigns_of(truth, law.design, SEED).campaigns)
    also = drawn.planted(1.5 * size_of(drawn, bare, SEED), np.array(truth.magnetic_enu_ut))
    found = diagnose(campaigns_of(truth, law.design, SEED, also, stated=truth).campaigns)
    more = discover(found)
    (one,) = more.proposals
    does = drawn.done(more.evidence)
    assert max(likeness(more.evidence, [each], does) for each in one.columns) > 0.98
    assert one.p < 0.01
    assert one.held_out[1] < one.held_out[0]
    assert one.share > 0.5


def test_a_good_bench_has_nothing_proposed() -> None:
    found = diagnose(campaigns_of(truth_of("plain", SEED), "plain", SEED).campaigns)
    assert discover(found).proposals == ()


def test_zones_lie_where_a_sensor_s_inputs_do_and_a_rate_of_rounding_is_no_input() -> None:
    evidence = bare_evidence(campaigns_of(truth_of("plain", SEED), "plain", SEED).campaigns)
    terms = library(evidence.excitation, ["gyroscope"])
    texts = {text for term in terms for text in term.texts}
    assert {"u * exp(-(u / w)**4)", "omega_2 * abs(omega_2)"} <= texts
    assert not any("T_rate" in text for text in texts)
    widths = {one.value for term in terms for one in term.shape.values() if one.unit == "deg/s"}
    u = np.abs(evidence.excitation.omega)
    for width in (u[u > 0].max() / 2, np.median(u[u > 0])):
        assert min(abs(np.log(each / width)) for each in widths) < np.log(1.25)
    seen = evidence.excitation
    turned = [i for i, step in enumerate(seen.steps) if step.kind == "turn"]
    slowest = min(float(np.median(u[seen.step == i].max(axis=1))) for i in turned)
    zones = [term for term in terms if any("exp(-(u / w)**4)" in text for text in term.texts)]
    assert zones
    assert all(term.shape["w"].high < slowest for term in zones)


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


def test_a_knee_that_is_fitted_above_the_fastest_rate_does_nothing_and_is_no_error() -> None:
    truth = truth_of("speeds", 409_000)
    evidence = bare_evidence(campaigns_of(truth, "speeds", 409_000).campaigns)
    (effect,) = (each for each in EFFECTS if each.name == "gyroscope.counts_lost")
    fastest = float(np.abs(evidence.excitation.omega).max())
    (last,) = effect.columns(evidence.excitation)[-1:]
    columns = effect.at(evidence.excitation, replace(last, nonlinear={"knee_deg_s": 0.99 * fastest}))
    nothing = np.zeros(len(evidence.x), dtype=bool)
    way = Candidate(effect, columns, term_of(evidence, effect, columns), nothing)
    (found,) = fitted_way(evidence, fit_linear(evidence, [], factor=np.ones(len(evidence.residual))), [way])
    assert 0.4 * fastest < found.columns.nonlinear["knee_deg_s"] < fastest
    bent = effect.at(evidence.excitation, replace(last, nonlinear={"knee_deg_s": 0.7 * fastest}))
    evidence = replace(evidence, residual=1e-3 * term_of(evidence, effect, bent).H.sum(axis=1))
    (found,) = fitted_way(evidence, fit_linear(evidence, [], factor=np.ones(len(evidence.residual))), [way])
    assert abs(found.columns.nonlinear["knee_deg_s"] / fastest - 0.7) < 0.02  # where one was planted it is found


@pytest.mark.parametrize(
    ("joint", "alone", "k", "products", "ways"),
    [
        (30.0, 25.0, 6, 2, [(30.0, 6, 1), (25.0, 2, 3)]),
        (30.0, 15.0, 3, 1, [(30.0, 3, 1), (15.0, 1, 3)]),
        (9.0, 9.0, 1, 2, [(9.0, 1, 1), (9.0, 2, 1)]),  # one sensor, one of whose two products is nought
    ],
)
def test_a_terms_p_is_the_lesser_of_two_ways_and_counts_both(
    joint: float, alone: float, k: int, products: int, ways: list[tuple[float, int, int]]
) -> None:
    found = search._log_p(np.array([joint]), np.array([alone]), np.array([k]), products)  # noqa: SLF001
    assert np.exp(found[0]) == pytest.approx(2 * min(n * chi2.sf(gain, dof) for gain, dof, n in ways))

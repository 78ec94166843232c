import numpy as np

from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import (
    holds_in_every_campaign,
    next_effect,
    rank_effects,
)
from procedures.diagnosis.held_out_errors import campaign_groups, left_out_groups
from procedures.diagnosis.residual_rows import Evidence
from tests.procedures.diagnosis.redrawn import made_up, redrawn, seen_by, small

CANDIDATES = 30


def pool_of(rng: np.random.Generator, evidence: Evidence) -> dict[str, list[Candidate]]:
    return {
        f"accelerometer.{i}": [made_up(evidence, rng.standard_normal((36, 1)), f"accelerometer.{i}")]
        for i in range(CANDIDATES)
    }


def test_of_thirty_candidates_on_noise_five_in_a_hundred_runs_at_most_adopt_one() -> None:
    rng, adopted, runs = np.random.default_rng(1), 0, 150
    base = small(rng)
    pool, left_out = pool_of(rng, base), left_out_groups(base)
    for _ in range(runs):
        evidence = redrawn(base, rng)
        tried = rank_effects(evidence, pool)
        assert len(tried) == CANDIDATES
        adopted += next_effect(evidence, tried, (), left_out) is not None
    assert adopted <= 0.05 * runs + 2 * np.sqrt(0.05 * 0.95 * runs)
    assert adopted > 0  # a rule that never adopts would pass otherwise


def test_one_term_of_eight_sigma_is_adopted() -> None:
    rng, right, runs = np.random.default_rng(2), 0, 30
    base = small(rng)
    pool, left_out = pool_of(rng, base), left_out_groups(base)
    for i in range(runs):
        name = f"accelerometer.{i % CANDIDATES}"
        way = pool[name][0]
        size = 8 * np.sqrt(way.fit(base, (), np.ones(36)).coefficients()[1][0, 0])
        evidence = redrawn(base, rng, way.term.H[:, 0] * size)
        new = next_effect(evidence, rank_effects(evidence, pool), (), left_out)
        right += new is not None and new.candidate.effect.name == name
    assert right >= 0.96 * runs


def test_an_effect_that_another_campaign_of_the_unit_speaks_against_is_refused() -> None:
    _, evidence, pool = seen_by("two temperatures")
    way, rng = pool["gyroscope.g_sensitivity"][0], np.random.default_rng(6)
    first, second = campaign_groups(evidence)
    assert set(first).isdisjoint(second)
    size = np.zeros(9)
    size[0] = 12 * np.sqrt(way.fit(evidence, (), np.ones(len(evidence.sigma))).coefficients()[1][0, 0])
    in_both = way.term.H @ size
    in_one = np.where(np.isin(np.arange(len(in_both)), first), in_both, 0.0)
    borne_out = [holds_in_every_campaign(redrawn(evidence, rng, in_both), way, ()) for _ in range(10)]
    refused = [not holds_in_every_campaign(redrawn(evidence, rng, in_one), way, ()) for _ in range(10)]
    assert np.mean(borne_out) >= 0.9
    assert np.mean(refused) >= 0.9

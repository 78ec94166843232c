import itertools

import numpy as np
import pytest

from procedures.frames import POSITIONS
from procedures.planning.campaign_design import TURN_PLACINGS, of_positions
from procedures.planning.order_search import OrderSearch, flips
from tests.procedures.planning.bench_of_moves import ARCSEC, bench, gyroscopes, unit


def test_the_search_is_within_5_percent_of_every_order_there_is() -> None:
    engine, among, seconds = bench(unit()), range(1, len(POSITIONS) + 1), 50.0
    asked = gyroscopes(k=5e-6, bias=0.02)
    can = flips()
    every = [
        order for order in itertools.permutations(among, 4)
        if all(can[a - 1, b - 1] for a, b in itertools.pairwise(order))
    ]  # fmt: skip
    assert len(every) > 1000
    least = min(float(asked.score(engine.of(of_positions(order, seconds)))) for order in every)
    found, score = OrderSearch(engine, asked, seconds, among).best(4)
    assert np.isfinite(score)
    assert score <= 1.05 * least
    assert score == pytest.approx(float(asked.score(engine.of(found))), rel=1e-3)


def test_an_order_has_a_scale_factor_of_2_2_ppm_and_a_misalignment_of_1_8_arcsec() -> None:
    engine, asked = bench(unit()), gyroscopes(k=2.2e-6, misalignment=1.8 * ARCSEC)
    found, _ = OrderSearch(engine, asked, 100.0).best(12)
    assert asked.worst(engine.of(found)) < 1
    assert len(set(found.positions)) == 12
    steps = [flips()[a - 1, b - 1] for a, b in itertools.pairwise(found.positions)]
    assert all(steps)


def test_the_scores_of_exchanges_are_those_of_whole_designs_with_turns_after_them() -> None:
    engine, asked = bench(unit()), gyroscopes(k=2e-6, misalignment=ARCSEC, bias=0.01)
    for moves in (False, True):
        found, score = OrderSearch(engine, asked, 60.0, tail=TURN_PLACINGS, moves=moves).best(6, beginnings=2)
        assert found.placings[6:] == TURN_PLACINGS
        assert score == pytest.approx(float(asked.score(engine.of(found))), rel=1e-5)

"""Holm's p-values: by hand, and on sets in which nothing is true."""

import numpy as np
import pytest

from procedures.statistics.multiple_testing import holm, two_sided


def test_holm_multiplies_by_the_tests_left_and_never_falls() -> None:
    found = holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005})
    assert found == pytest.approx({"d": 0.02, "a": 0.03, "c": 0.06, "b": 0.06})
    assert list(found) == ["a", "b", "c", "d"]
    assert holm({"a": 0.9, "b": 0.8}) == {"a": 1.0, "b": 1.0}
    assert holm({}) == {}


def test_of_logarithms_it_is_the_logarithm() -> None:
    p = dict(enumerate((0.001, 0.015, 0.016, 0.4)))
    by_hand = [0.004, 0.045, 0.045, 0.4]  # 4 x 0.001, 3 x 0.015, the larger of 2 x 0.016 and that, 1 x 0.4
    found = holm({key: np.log(value) for key, value in p.items()}, are_logs=True)
    assert np.exp(list(found.values())) == pytest.approx(by_hand)
    assert list(holm(p).values()) == pytest.approx(by_hand)
    assert list(holm({0: 0.04, 1: 0.01, 2: 0.03}).values()) == pytest.approx([0.06, 0.03, 0.06])


def test_five_per_cent_of_sets_of_nothing_show_something() -> None:
    rng, sets = np.random.default_rng(1), 2000
    alarms = sum(
        min(holm({i: two_sided(z) for i, z in enumerate(rng.standard_normal(24))}).values()) < 0.05
        for _ in range(sets)
    )
    assert abs(alarms / sets - 0.05) < 4 * np.sqrt(0.05 * 0.95 / sets)

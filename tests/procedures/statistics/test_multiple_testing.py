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


def test_five_per_cent_of_sets_of_nothing_show_something() -> None:
    rng, sets = np.random.default_rng(1), 2000
    alarms = sum(
        min(holm({i: two_sided(z) for i, z in enumerate(rng.standard_normal(24))}).values()) < 0.05
        for _ in range(sets)
    )
    assert abs(alarms / sets - 0.05) < 4 * np.sqrt(0.05 * 0.95 / sets)

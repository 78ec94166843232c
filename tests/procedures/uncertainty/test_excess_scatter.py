"""What a failing global test adds to every observation, by R. T. Birge's ratio and by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from procedures.uncertainty.excess_scatter import TemperatureEffect, unexplained, unexplained_within
from procedures.uncertainty.sources import UNEXPLAINED, SourceCell

SEEN = np.array([True, True, False])


def test_squares_twice_their_degrees_of_freedom_double_the_variance_of_what_was_observed() -> None:
    """40 of 20 has p = 0.005; the extra variance, 1 of 2, is known as by a quarter of the degrees of freedom."""
    ((cell, share),) = unexplained("accelerometer", 40.0, 20, SEEN, None).items()
    assert cell == SourceCell(UNEXPLAINED, "accelerometer", 5.0)
    assert share.tolist() == [1.0, 1.0, 0.0]


def test_squares_that_pass_add_nothing_unless_a_diagnosis_says_that_something_is_left() -> None:
    """26 of 20 has p = 0.17; the extra, 0.3 of 1.3, would be known as by 20 (0.3 / 1.3)^2 = 1.07."""
    assert unexplained("accelerometer", 26.0, 20, SEEN, None) == {}
    ((cell, share),) = unexplained("accelerometer", 26.0, 20, SEEN, None, is_left=True).items()
    assert cell.dof == pytest.approx(20 * (0.3 / 1.3) ** 2)
    assert share == pytest.approx([0.3, 0.3, 0.0])
    ((cell, _),) = unexplained("accelerometer", 21.0, 20, SEEN, None, is_left=True).items()
    assert cell.dof == 1.0
    for chi2, dof in ((20.0, 20), (19.0, 20), (40.0, 0), (40.0, -1)):
        assert unexplained("accelerometer", chi2, dof, SEEN, None, is_left=True) == {}
    (share,) = unexplained("accelerometer", 9.0, 1, SEEN, None).values()  # p = 0.003, at one degree of freedom
    assert share.tolist() == [8.0, 8.0, 0.0]


def test_what_temperature_explains_of_the_squares_is_not_counted_twice() -> None:
    effect: Any = SimpleNamespace(chi2=16.0, rank=2)
    temperature: TemperatureEffect = effect
    assert unexplained("accelerometer", 40.0, 20, SEEN, temperature) == {}  # 24 of 18
    ((cell, share),) = unexplained("accelerometer", 52.0, 20, SEEN, temperature).items()  # 36 of 18
    assert share.tolist() == [1.0, 1.0, 0.0]
    assert cell.dof == 18 / 4


def test_what_drifts_within_dwells_adds_to_their_counting_noise() -> None:
    """Of 2 dwells whose noise is half of their sigma 3 squares add 3 / 4 of a variance each, of others none."""
    joint: Any = SimpleNamespace(
        seen=SimpleNamespace(dwells=[1, 2]), fit=SimpleNamespace(residual=np.zeros(8)),
        expected=np.ones((2, 3)), sigma=2 * np.ones((2, 3)),
    )  # fmt: skip
    ((cell, share),) = unexplained_within("gyroscope", joint, 32, 3.0).items()
    assert cell == SourceCell(UNEXPLAINED, "gyroscope", 18.0)
    assert share.tolist() == [0.75] * 6 + [0.0] * 2
    ((cell, _),) = unexplained_within("gyroscope", joint, 3, 0.1).items()
    assert cell.dof == 1.0
    assert unexplained_within("gyroscope", joint, 32, 0.0) == {}
    joint.seen.dwells = []
    assert unexplained_within("gyroscope", joint, 32, 3.0) == {}

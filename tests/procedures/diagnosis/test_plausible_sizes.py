"""How noisy a triad is, is told by its own rows."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from procedures.diagnosis.plausible_sizes import NAVIGATION_GRADE_STD, STD_PER_MAD, noise_in_navigation_grade

TIMES = noise_in_navigation_grade.__wrapped__


def seen(kind: str, times: float) -> Any:
    """Return rows of accelerometers alone, so many times as noisy as of navigation grade; x wanders."""
    axis = np.repeat([0, 1, 2], 5)
    sigma = np.full(15, times * NAVIGATION_GRADE_STD[0])
    return SimpleNamespace(
        triad=np.zeros(15, dtype=int), axis=axis, sigma=sigma,
        residual=sigma * np.where(axis == 0, 10.0, 0.1) * np.tile([-1.0, 1.0, -1.0, 1.0, 1.0], 3),
        rows=lambda *kinds: np.full(15, kind in kinds),
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["mean", "norm", "soak"])
def test_a_triad_is_as_noisy_as_its_own_rows_and_one_without_as_of_navigation_grade(kind: str) -> None:
    evidence = seen(kind, 7.0)
    assert TIMES(evidence, 0, False) == pytest.approx(7.0)
    other = seen(kind, 1e9)  # whatever the other one is like
    assert TIMES(other, 1, False) == TIMES(other, 1, True) == 1.0
    assert TIMES(seen(kind, 0.1), 0, False) == 1.0


def test_where_a_channel_was_measured_a_soak_is_as_noisy_as_its_sensor_that_wanders_most() -> None:
    assert TIMES(seen("soak", 7.0), 0, True) == pytest.approx(70.0 * STD_PER_MAD)

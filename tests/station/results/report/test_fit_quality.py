"""Residuals and correlations made by hand, as the report's tables give them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from procedures.calibration.solution_values import StepResidual
from station.results.report.fit_quality import correlations, normalised, residual_tables

DWELL = StepResidual(
    "dwell_05", "dwell", "accelerometer", 5, np.array([1e-6, -2e-6, 0.0]), np.array([1e-6, 1e-6, 2e-6]), "g"
)


def plain(text: str) -> str:
    return text.strip("\u2007\u2008").replace("\u2212", "-")


def test_a_residual_is_set_against_four_sigma_in_the_unit_of_its_triad() -> None:
    turn = StepResidual("turn", "turn", "gyroscope", 0, np.full(3, 1e-3), np.full(3, 1e-2), "deg")
    first, second = residual_tables([DWELL, turn])
    assert (first.triad, first.kind, first.unit) == ("accelerometer", "dwell", "\u00b5g")
    ((name, where, cells, worst, mark),) = first.rows
    assert (name, where.split()[0]) == ("dwell_05", "5")
    assert [plain(each) for each in cells] == ["+1.0", "4.0", "-2.0", "4.0", "+0.0", "8.0"]
    assert (worst, mark) == ("2.0", "")
    ((_, where, cells, worst, _),) = second.rows
    assert (second.unit, where, worst) == ("arcsec", "\u2013", "0.1")
    assert [plain(each) for each in cells[:2]] == ["+4", "144"]  # two digits of 36 arcsec


@pytest.mark.parametrize(
    ("largest", "mark"), [(2.0, ""), (2.1, "above 2"), (-4.0, "above 2"), (-4.1, "over the limit")]
)
def test_a_step_is_marked_by_its_largest_residual(largest: float, mark: str) -> None:
    residual = np.array([0.0, largest * 1e-6, 1e-6])
    ((*_, worst, said),) = residual_tables([replace(DWELL, residual=residual)])[0].rows
    assert worst == f"{abs(largest):.1f}"
    assert (mark in said) if mark else said == ""


def test_an_axis_without_a_sigma_has_no_ratio() -> None:
    dead = replace(DWELL, sigma=np.array([0.0, 1e-6, np.nan]))
    assert normalised(dead) == pytest.approx([np.nan, -2.0, np.nan], nan_ok=True)
    ((*_, worst, mark),) = residual_tables([replace(DWELL, sigma=np.zeros(3))])[0].rows
    assert (worst, mark) == ("\u2013", "")


def test_correlations_of_a_half_and_more_are_listed_the_largest_first() -> None:
    std = np.array([2.0, 0.0, 3.0, 0.5])
    R = np.array([[1, 0, 0.5, -0.9], [0, 1, 0, 0], [0.5, 0, 1, 0.49], [-0.9, 0, 0.49, 1]])
    solution = SimpleNamespace(covariance=R * np.outer(std, std), names=("a", "b", "c", "d"))
    found = correlations(solution)  # type: ignore[arg-type]
    assert [(one, other, plain(text)) for one, other, text, _ in found] == [
        ("a", "d", "-0.900"),
        ("a", "c", "+0.500"),
    ]
    assert [size for *_, size in found] == pytest.approx([0.9, 0.5])

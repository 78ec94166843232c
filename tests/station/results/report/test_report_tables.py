"""Numbers of the report's tables: residuals against four sigma, correlations, parameters with U and truth."""

from types import SimpleNamespace

import numpy as np
import pytest

from procedures.calibration.solution_values import StepResidual
from station.results.report.result_tables import correlations, residual_tables, triad_results

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


BIAS = {"value": [-1.5, 20.25, 0.0], "std": [0.05, 0.12, 0.2], "unit": "deg/h"}
DOCUMENT = {
    "gyroscope": {
        "scale_factor": {"value": [36000.0, 35500.0, 36300.0], "std": [0.2] * 3, "unit": "count/s per deg/s"},
        "misalignment": {"value": np.eye(3).tolist(), "std": np.full((3, 3), 1e-6).tolist(), "unit": "1"},
        "bias": BIAS,
        "bias_12_position": BIAS,
    }
}
TRUTH = {"gyroscope.bias.x": -1.56, "gyroscope.bias.y": 20.45}


def cells(group: int, axis: int) -> list[str]:
    (triad,) = triad_results(DOCUMENT, TRUTH, {"gyroscope.bias.x": 0.11})
    found = triad.groups[group].rows[axis]
    return [each.strip("\u2007\u2008").replace("\u2212", "-") for each in found]


def test_a_bias_is_printed_with_u_sigma_interval_truth_and_error() -> None:
    # -1.5 +- 1.96 x 0.05; off its truth by +0.06, 1.2 sigma
    shown = ["-1.500", "0.11", "0.050", "-1.598", "-1.402", "deg/h", "-1.560", "+0.060", "+1.2"]
    assert cells(2, 0)[2:] == shown
    assert cells(2, 1)[2:] == ["20.25", "", "0.12", "20.01", "20.49", "deg/h", "20.45", "-0.20", "-1.7"]
    assert cells(2, 2)[2:] == ["0.00", "", "0.20", "-0.39", "0.39", "deg/h", "", "", ""]
    assert [cells(2, axis)[1] for axis in range(3)] == ["x", "y", "z"]

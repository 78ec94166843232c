"""A triad of round numbers as the report's tables print it."""

import numpy as np

from procedures.calibration.solution_values import Estimate, TriadCalibration
from station.results.report.parameter_tables import matrix_rows, triad_groups

BIAS = Estimate(np.array([-1.5, 20.25, 0.0]), np.array([0.05, 0.12, 0.2]), "deg/h")
TRIAD = TriadCalibration(
    Estimate(np.array([36000.0, 35500.0, 36300.0]), np.array([0.2, 0.2, 0.2]), "count/s per deg/s"),
    Estimate(np.eye(3), np.full((3, 3), 1e-6), "1"), BIAS, bias_12_position=BIAS,
)  # fmt: skip
TRUTH = {"gyroscope.bias.x": -1.56, "gyroscope.bias.y": 20.45}


def cells(group: int, axis: int) -> list[str]:
    found = triad_groups("gyroscope", TRIAD, TRUTH, {"gyroscope.bias.x": 0.11})[group].rows[axis]
    return [each.strip("\u2007\u2008").replace("\u2212", "-") for each in found]


def test_a_bias_is_printed_with_u_sigma_interval_truth_and_error() -> None:
    # -1.5 +- 1.96 x 0.05; off its truth by +0.06, 1.2 sigma
    shown = ["-1.500", "0.11", "0.050", "-1.598", "-1.402", "deg/h", "-1.560", "+0.060", "+1.2"]
    assert cells(2, 0)[2:] == shown
    assert cells(2, 1)[2:] == ["20.25", "", "0.12", "20.01", "20.49", "deg/h", "20.45", "-0.20", "-1.7"]
    assert cells(2, 2)[2:] == ["0.00", "", "0.20", "-0.39", "0.39", "deg/h", "", "", ""]
    assert [cells(2, axis)[1] for axis in range(3)] == ["x", "y", "z"]


def test_the_textbooks_bias_is_compared_with_the_same_truth_but_not_in_its_sigmas() -> None:
    groups = triad_groups("gyroscope", TRIAD, TRUTH, {})
    assert [group.title for group in groups] == [
        "Scale factor k", "Misalignment E", "Bias D", "Bias, 12-position mean",
    ]  # fmt: skip
    assert cells(3, 0)[2:] == ["-1.500", "", "0.050", "-1.598", "-1.402", "deg/h", "-1.560", "+0.060", ""]


def test_a_matrix_has_the_sigma_of_its_last_digits_in_parentheses() -> None:
    E = Estimate(np.array([[1.0, 2.345e-4]]), np.array([[0.0, 1.2e-6]]), "1")
    assert matrix_rows(E) == [["1.000000", "0.0002345(12)"]]

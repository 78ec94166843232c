"""What is drawn of a finding: each sensor's rows, before and after, where they stand."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from station.results.diagnosis.finding_figure import caption, draw_panel
from station.results.diagnosis.finding_residuals import ResidualPanel
from station.results.diagnosis.plot_coordinates import Coordinate

PANEL = ResidualPanel(
    "accelerometer.quadratic", "accelerometer", "mean", "ug",
    Coordinate("specific force [g]", np.array([-1.0, 0.0, 1.0])),
    np.array([0, 0, 2]), np.array([3.0, 4.0, 0.0]), np.array([0.3, 0.4, 0.0]), np.array([1.0, 2.0, 3.0]),
)  # fmt: skip


def test_the_rows_of_each_sensor_are_drawn_before_and_after() -> None:
    figure = Figure()
    draw_panel(figure, PANEL)
    left, right = figure.axes
    for axes, values in ((left, [[3.0, 4.0], [0.0]]), (right, [[0.3, 0.4], [0.0]])):
        drawn = axes.containers
        assert [each.get_label() for each in drawn] == ["ax", "az"]
        assert [each.lines[0].get_xdata().tolist() for each in drawn] == [[-1.0, 0.0], [1.0]]
        assert [each.lines[0].get_ydata().tolist() for each in drawn] == values
    assert left.get_title(loc="left") == "without it: 2.89 \u00b5g rms"  # sqrt(25 / 3)
    assert right.get_title(loc="left") == "with it: 0.289 \u00b5g rms"
    assert caption(PANEL) == "Accelerometer, dwells; bars: 1\u03c3 of counting noise."


def test_steps_that_only_have_names_stand_apart_by_sensor() -> None:
    named = Coordinate("position", np.array([0.0, 0.0, 0.0]), ("1",))
    figure = Figure()
    draw_panel(
        figure, ResidualPanel("x", "gyroscope", "rate", "deg/h", named, np.array([0, 1, 2]), *np.ones((3, 3)))
    )
    at = [each.lines[0].get_xdata()[0] for each in figure.axes[0].containers]
    assert at == pytest.approx([-0.2, 0.0, 0.2])
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["1"]

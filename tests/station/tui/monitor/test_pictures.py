"""Horizon and charts, by what stands where."""

import math

import pytest

from station.tui.monitor.horizon_picture import horizon_picture
from station.tui.monitor.widgets import drawn_range, line_dots


def ground(roll: float, pitch: float) -> list[list[bool]]:
    """Return which cells (11 rows of 33) are ground, by their background."""
    content = horizon_picture(33, 11, roll, pitch)
    rows, at = list[list[bool]](), 0
    for line in content.plain.split("\n"):
        spans = [span for span in content.spans if "on $" in str(span.style)]
        rows.append([any(s.start <= at + i < s.end and "$ground" in str(s.style).split(" on ")[-1] for s in spans)
                     for i in range(len(line))])  # fmt: skip
        at += len(line) + 1
    return rows


def test_level_has_sky_above_and_ground_below() -> None:
    rows = ground(0.0, 0.0)
    assert not any(rows[0])
    assert all(rows[-1])


def test_nose_up_shows_sky_and_nose_down_ground() -> None:
    assert not any(map(any, ground(0.0, 30.0)))
    assert all(map(all, ground(0.0, -30.0)))


def test_right_wing_down_raises_the_ground_on_the_right() -> None:
    rows = ground(30.0, 0.0)
    assert sum(row[-1] for row in rows) > sum(row[0] for row in rows) + 4


def test_upside_down_has_the_ground_above() -> None:
    rows = ground(180.0, 0.0)
    assert all(rows[0])
    assert not any(rows[-1])


@pytest.mark.parametrize("pitch", [-90.0, 0.0, 45.0, 90.0])
@pytest.mark.parametrize("roll", [-180.0, -91.0, 0.0, 13.0])
def test_every_attitude_is_drawn_in_its_size(roll: float, pitch: float) -> None:
    lines = horizon_picture(20, 7, roll, pitch).plain.split("\n")
    assert [len(line) for line in lines] == [20] * 7


def test_a_single_peak_among_many_values_is_seen() -> None:
    values = [0.0] * 600
    values[300] = 1.0
    dots = line_dots(values, 40, 8, 0.0, 1.0, 600)
    assert {column // 2 for row, column in dots if row < 4} == {10}


def test_few_values_stand_on_the_right_and_what_is_unknown_is_left_out() -> None:
    dots = line_dots([0.5, math.nan], 20, 4, 0.0, 1.0, 20)
    assert {column // 2 for _, column in dots} == {9}
    assert drawn_range([math.nan], 1.0) is None
    assert drawn_range([2.0, 2.0], 1.0) == (1.5, 2.5)

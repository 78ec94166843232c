"""Horizon, charts and map of the monitor, by what stands where."""

import math
from dataclasses import replace

import pytest

from station.locate.location import Location
from station.tui.monitor_pictures import horizon_picture, map_picture
from station.tui.monitor_widgets import line_dots


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


def test_a_single_peak_among_many_values_is_seen() -> None:
    values = [0.0] * 600
    values[300] = 1.0
    dots = line_dots(values, 40, 8, 0.0, 1.0, 600)
    assert {column // 2 for row, column in dots if row < 4} == {10}


AT = Location(is_located=True, enu=(100.0, 0.0, 0.0), heading=90.0, track=((0.0, 0.0), (100.0, 0.0)))


def map_rows(location: Location, width: int = 34, height: int = 11) -> list[str]:
    return map_picture(width, height, location).plain.split("\n")


def place(location: Location, mark: str) -> tuple[int, int]:
    (found,) = [(row, line.index(mark)) for row, line in enumerate(map_rows(location)) if mark in line]
    return found


def test_east_is_on_the_right_and_north_above() -> None:
    assert place(AT, "→")[1] > place(AT, "+")[1] + 20
    assert place(AT, "→")[0] == place(AT, "+")[0]
    north = replace(AT, enu=(0.0, 100.0, 0.0), track=((0.0, 0.0), (0.0, 100.0)), heading=0.0)
    arrow = [row for row, line in enumerate(map_rows(north)) if "↑" in line.replace("N↑", "")]
    assert place(north, "+")[0] > arrow[0] + 6


@pytest.mark.parametrize(
    ("heading", "arrow"), [(0, "↑"), (46, "↗"), (181, "↓"), (300, "↖"), (359, "↑"), (None, "●")]
)
def test_an_arrow_says_which_way_it_points(heading: float | None, arrow: str) -> None:
    assert arrow in "".join(map_rows(replace(AT, heading=heading))).replace("N↑", "")


def test_a_way_is_as_long_as_its_scale_says() -> None:
    bar = map_rows(AT)[-1]
    assert bar.strip().endswith("50 m")
    metres = 50 / (bar.index("┤") - bar.index("├") + 1)
    assert (place(AT, "→")[1] - place(AT, "+")[1]) * metres == pytest.approx(100.0, rel=0.1)


@pytest.mark.parametrize("size", [1.0, 37.0, 900.0, 1e5])
@pytest.mark.parametrize("shape", [(34, 11), (58, 16)])
def test_any_way_fits_and_fills_half_of_the_sheet(size: float, shape: tuple[int, int]) -> None:
    ring = tuple((size * math.sin(i / 10), size * math.cos(i / 10)) for i in range(64))
    lines = map_rows(Location(is_located=True, track=ring, enu=(*ring[-1], 0.0)), *shape)
    assert [len(line) for line in lines] == [shape[0]] * shape[1]
    drawn = [row for row, line in enumerate(lines[:-1]) if any(0x2800 < ord(c) < 0x2900 for c in line)]
    if size > 10:
        assert drawn[-1] - drawn[0] > 0.4 * shape[1]

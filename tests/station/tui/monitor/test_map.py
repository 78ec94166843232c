"""The map, by what stands where."""

import math
from dataclasses import replace

import pytest

from station.locate.location import Location
from station.tui.monitor.map_picture import map_picture

AT = Location(is_located=True, enu=(100.0, 0.0, 0.0), heading=90.0, track=((0.0, 0.0), (100.0, 0.0)))


def rows(location: Location, width: int = 34, height: int = 11) -> list[str]:
    return map_picture(width, height, location).plain.split("\n")


def place(location: Location, mark: str) -> tuple[int, int]:
    (found,) = [(row, line.index(mark)) for row, line in enumerate(rows(location)) if mark in line]
    return found


def test_east_is_on_the_right_and_north_above() -> None:
    assert place(AT, "→")[1] > place(AT, "+")[1] + 20
    assert place(AT, "→")[0] == place(AT, "+")[0]
    north = replace(AT, enu=(0.0, 100.0, 0.0), track=((0.0, 0.0), (0.0, 100.0)), heading=0.0)
    arrow = [row for row, line in enumerate(rows(north)) if "↑" in line.replace("N↑", "")]
    assert place(north, "+")[0] > arrow[0] + 6


@pytest.mark.parametrize(
    ("heading", "arrow"), [(0, "↑"), (46, "↗"), (181, "↓"), (300, "↖"), (359, "↑"), (None, "●")]
)
def test_an_arrow_says_which_way_it_points(heading: float | None, arrow: str) -> None:
    assert arrow in "".join(rows(replace(AT, heading=heading))).replace("N↑", "")


def test_a_way_is_as_long_as_its_scale_says() -> None:
    bar = rows(AT)[-1]
    assert bar.strip().endswith("50 m")
    metres = 50 / (bar.index("┤") - bar.index("├") + 1)
    assert (place(AT, "→")[1] - place(AT, "+")[1]) * metres == pytest.approx(100.0, rel=0.1)


def test_fixes_that_stand_off_are_drawn_where_they_are_on_the_sheet() -> None:
    assert place(replace(AT, far=((50.0, 0.0),)), "✗")[1] in range(14, 21)
    assert not any("✗" in line for line in rows(replace(AT, far=((5000.0, 0.0),))))


@pytest.mark.parametrize("size", [1.0, 37.0, 900.0, 1e5])
@pytest.mark.parametrize("shape", [(34, 11), (58, 16)])
def test_any_way_fits_and_fills_half_of_the_sheet(size: float, shape: tuple[int, int]) -> None:
    ring = tuple((size * math.sin(i / 10), size * math.cos(i / 10)) for i in range(64))
    lines = rows(Location(is_located=True, track=ring, enu=(*ring[-1], 0.0)), *shape)
    assert [len(line) for line in lines] == [shape[0]] * shape[1]
    drawn = [row for row, line in enumerate(lines[:-1]) if any(0x2800 < ord(c) < 0x2900 for c in line)]
    if size > 10:
        assert drawn[-1] - drawn[0] > 0.4 * shape[1]

"""Positions that are named by where the cube's axes point, on a small screen."""

from tests.station.tui.flip_views import FLIPPING
from tests.station.tui.session import SMALL, screens


async def test_a_position_named_by_its_axes_is_drawn_and_has_its_cell() -> None:
    async with screens(FLIPPING, SMALL) as seen:
        await seen.show(FLIPPING)
        text = "\n".join(seen.lines())
    assert "put the cube in position SDE: X south, Y down, Z east" in text
    assert "where X, Y, Z point" in text
    assert "▶SDE" in text
    assert "-Y up" in text
    assert "no move to it: samples were lost" in text

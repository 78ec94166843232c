"""A level frame about a place: against the Earth's radii of curvature, there and back, across the date line."""

import numpy as np
import pytest

from procedures.earth.geodesy import LocalLevel


def test_a_second_of_arc_is_as_long_as_the_tables_say() -> None:
    origin = LocalLevel(np.radians(45.0), 0.1)
    second = np.radians(1 / 3600)
    east, north = origin.enu(origin.latitude, origin.longitude + second, 0)[0], origin.enu(
        origin.latitude + second, origin.longitude, 0
    )[1]  # fmt: skip
    assert east == pytest.approx(78847 / 3600, abs=2e-4)  # m a degree at 45 deg, WGS 84
    assert north == pytest.approx(111132 / 3600, abs=2e-4)


@pytest.mark.parametrize("place", [(0.0, 0.0), (48.1, 11.5), (-33.9, 179.9999), (89.9, -120.0)])
@pytest.mark.parametrize("enu", [(0.0, 0.0, 0.0), (1234.5, -987.6, 54.3), (40e3, 40e3, 8e3)])
def test_there_and_back_is_the_same(place: tuple[float, float], enu: tuple[float, float, float]) -> None:
    origin = LocalLevel(*np.radians(place), 321.0)
    assert origin.enu(*origin.geodetic(np.array(enu))) == pytest.approx(enu, abs=1e-6)


def test_up_is_up() -> None:
    origin = LocalLevel(np.radians(48.1), np.radians(11.5), 500.0)
    assert origin.enu(origin.latitude, origin.longitude, 512.0) == pytest.approx([0, 0, 12.0], abs=1e-8)

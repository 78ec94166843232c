from dataclasses import replace

import numpy as np
import pytest

from procedures.geodesy import EARTH_RATE, LocalLevel, earth_rate_n, normal_gravity
from procedures.gnss_records import FixType, GnssFix, averaged_site


@pytest.mark.parametrize(
    ("latitude_deg", "printed"), [(0, 9.780325), (45, 9.806198), (90, 9.832185), (-45, 9.806198)]
)
def test_normal_gravity_is_that_of_wgs_84(latitude_deg: float, printed: float) -> None:
    assert abs(normal_gravity(np.radians(latitude_deg)) - printed) < 0.6e-6  # printed to a microgal times 100


def test_gravity_falls_by_the_free_air_gradient() -> None:
    gradient = (normal_gravity(np.radians(45), 1.0) - normal_gravity(np.radians(45), 0.0)) / 1.0
    assert abs(gradient + 3.0855e-6) < 1e-9  # -0.30855 mGal/m at 45 deg; the second order is 1.4e-12 of it
    half, whole = (normal_gravity(0.5, h) - normal_gravity(0.5) for h in (5000.0, 10000.0))
    assert 0 < (whole - 2 * half) / whole * -1 < 2e-3 * 1.1  # it weakens with height: 3 h^2 / a^2 / (2 h / a)


def test_the_earth_turns_once_a_sidereal_day_and_has_no_eastward_part() -> None:
    rate = earth_rate_n(np.radians(31.17))
    assert rate[0] == 0
    assert np.linalg.norm(rate) == pytest.approx(2 * np.pi / 86164.0989, rel=1e-7)
    assert rate[1:] == pytest.approx(EARTH_RATE * np.array([np.cos(0.5440191), np.sin(0.5440191)]), rel=1e-6)
    assert earth_rate_n(-0.5)[2] < 0


def _gravity_by_the_potential(latitude: float, height: float) -> float:
    """Return gravity [m/s2] by the gradient of WGS 84's potential: even zonal harmonics and the rotation."""
    a, e2, gm, omega = 6378137.0, 0.00669437999014, 3.986004418e14, 7.292115e-5
    j = {
        2: 1.082629821e-3,
        4: -2.37091120e-6,
        6: 6.08347e-9,
        8: -1.42681e-11,
    }  # TR8350.2, table 3.3, (3-62)

    def potential(x: float, z: float) -> float:
        r = np.hypot(x, z)
        legendre = {n: np.polynomial.legendre.Legendre.basis(n)(z / r) for n in j}
        return gm / r * (1 - sum(j[n] * (a / r) ** n * legendre[n] for n in j)) + 0.5 * (omega * x) ** 2

    n = a / np.sqrt(1 - e2 * np.sin(latitude) ** 2)
    x, z = (n + height) * np.cos(latitude), (n * (1 - e2) + height) * np.sin(latitude)
    step = 100.0  # m; central differences of a field that is smooth over thousands of km
    return float(
        np.hypot(
            (potential(x + step, z) - potential(x - step, z)) / (2 * step),
            (potential(x, z + step) - potential(x, z - step)) / (2 * step),
        )
    )


@pytest.mark.parametrize("latitude_deg", [0.0, 31.17, 60.0])
@pytest.mark.parametrize("height", [0.0, 1000.0, 9000.0])
def test_gravity_at_a_height_is_the_gradient_of_the_potential(latitude_deg: float, height: float) -> None:
    latitude = np.radians(latitude_deg)
    # the series ends at (h / a)^2: at 9 km what it leaves out is 1e-7 m/s2
    assert normal_gravity(latitude, height) == pytest.approx(_gravity_by_the_potential(latitude, height), abs=1e-6)


# East-North-up coordinates about a place


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


# The site that fixes average to


FIX = GnssFix("GPS_RAW_INT", 1, 0, FixType.FIX_3D, latitude=0.8, longitude=0.2, altitude=500.0)


def test_fixes_alike_to_the_last_digit_are_reported() -> None:
    same, scattered = [FIX] * 20, [replace(FIX, latitude=0.8 + i * 1e-9) for i in range(20)]
    for fixes, is_constant in ((same, True), (scattered, False), (same[:19], False)):
        site = averaged_site(fixes)
        assert site is not None
        assert site.is_constant == is_constant

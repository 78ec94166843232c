import numpy as np
import pytest

from procedures.earth import EARTH_RATE, earth_rate_n, normal_gravity


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

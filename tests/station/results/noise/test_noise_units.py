"""Units of noise against each other: what is 1 in SI is the same number by each way there."""

import pytest

from procedures.units import DEG_H_PER_DEG_S, STANDARD_GRAVITY
from station.results.noise.noise_units import ACCELEROMETER, GYROSCOPE, OUTPUT, units_of

HOUR_S = 3600.0


@pytest.mark.parametrize(
    ("term", "power"),
    [
        ("quantisation", 0),
        ("random_walk", -0.5),
        ("bias_instability", 0),
        ("rate_random_walk", 0.5),
        ("rate_ramp", 1),
    ],
)
def test_a_term_is_in_hours_where_its_unit_says_so(term: str, power: float) -> None:
    assert GYROSCOPE[term][3] == pytest.approx(HOUR_S**power)
    assert OUTPUT[term][3] == 1.0
    in_hours = "h" in ACCELEROMETER[term][2].partition("/")[2].replace("Hz", "")
    expected = {"quantisation": STANDARD_GRAVITY}.get(term, HOUR_S**power if in_hours else 1.0)
    assert ACCELEROMETER[term][3] == pytest.approx(expected)


def test_a_triad_whose_scale_is_not_known_has_outputs() -> None:
    assert (units_of("gyroscope", False).unit, units_of("gyroscope", False).factor) == ("output", 1.0)
    assert units_of("gyroscope", True).factor == DEG_H_PER_DEG_S
    assert units_of("accelerometer", True).unit == "ug"

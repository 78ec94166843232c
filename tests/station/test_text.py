"""Numbers and words as they are printed: digits of a sigma, powers of ten, minus zero, one and several."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.results.fixtures.fixture_listing import chi2_text
from station.results.parameters_by_name import Parameter
from station.results.parameters_by_name import shown as shown_parameter
from station.results.solution_text import measured
from station.text import aligned, decimals, fixed, plural, significant


@pytest.mark.parametrize(
    ("value", "std", "shown", "sigma"),
    [
        (1020.00034, 0.00131, "1020.0003", "0.0013"),
        (-0.0000004, 0.01, "0.000", "0.010"),
        (-1.23456, 0.0996, "\u22121.23", "0.10"),
        (12345.0, 123.0, "12340", "120"),
        (5.0, 0.0, "5.000000", "0.000000"),
    ],
)
def test_a_value_is_rounded_to_two_digits_of_its_sigma(value: float, std: float, shown: str, sigma: str) -> None:
    assert fixed(value, decimals(std)) == shown
    assert fixed(std, decimals(std)) == sigma


@given(st.floats(1e-12, 1e9))
def test_two_significant_digits_lie_within_half_a_unit_of_the_second(std: float) -> None:
    shown = float(fixed(std, decimals(std)))
    assert abs(shown - std) <= 0.0501 * std


def test_numbers_align_on_their_points() -> None:
    assert aligned(["1.25", "10.3", "7"]) == ["1.25", "10.3\u2007", "7\u2008\u2007\u2007"]


def test_small_and_large_numbers_take_a_power_of_ten() -> None:
    assert significant(1.04e-8) == "1.0\u00b710\u207b\u2078"
    assert significant(0.0123) == "0.012"
    assert significant(12345.0) == "12000"
    assert significant(0.0) == "0"
    assert fixed(float("nan"), 2) == "\u2013"


def test_no_number_that_is_printed_is_minus_zero() -> None:
    assert measured(-0.2, 100.0, "urad") == "0 +- 100 urad"
    assert measured(-0.001, 0.5, "arcsec") == "0.00 +- 0.50 arcsec"
    assert shown_parameter(Parameter("accelerometer.bias.x", -1e-9, 1e-6, "g"))[0] == "0.0"
    assert chi2_text(3e-18, 4) == "0"
    assert chi2_text(0.25, 3) == "0.25"


def test_one_alone_is_singular() -> None:
    assert [plural(count, "gap") for count in (0, 1, 2)] == ["0 gaps", "1 gap", "2 gaps"]
    assert [plural(count, "fix") for count in (0, 1, 12)] == ["0 fixes", "1 fix", "12 fixes"]

"""What is not counted, and only where the program said so."""

import pytest

from procedures.units import RAD_PER_ARCSEC
from tests.year.unnoticed_leans import VALUES, untold_by_heading, untold_by_size, untold_values

SAID = [
    "a crumb under the cube would not be noticed in positions 3 (up to 16 arcsec), 10 (any size): accelerometer "
    "misalignment yx would be wrong; in position 1 (up to 30 arcsec): gyroscope scale factor and misalignment "
    "would be wrong by the moves that begin or end there"
]


def triads(leans: dict[str, float]) -> set[str]:
    return {name.split()[0] for name in untold_values(SAID, leans)}


def test_k_and_E_of_the_triad_are_not_counted_where_a_position_that_is_named_stood_askew() -> None:
    assert triads({"dwell_03": 4e-5}) == {"accelerometer"}
    assert triads({"dwell_10": 2e-3}) == {"accelerometer"}
    assert triads({"dwell_01": 1e-4}) == {"gyroscope"}
    assert set(untold_values(SAID, {"dwell_01": 1e-4})) >= {"gyroscope k x", "gyroscope E zy"}


def test_what_the_program_did_not_say_counts() -> None:
    assert not untold_values([], {"dwell_03": 4e-5})
    assert not triads({"dwell_02": 4e-5})


def test_what_a_seat_scatters_by_counts_and_so_does_what_would_show() -> None:
    for lean in (0.0, 1e-5, 2e-4):
        assert not triads({"dwell_03": lean})


@pytest.mark.parametrize(
    ("lean", "off", "is_untold"),
    [
        (7.0, 6.0, True),
        (7.0, -8.9, True),
        (7.0, 9.1, False),
        (7.0, 3.9, False),
        (20.0, 6.0, False),
        (2.0, 6.0, False),
    ],
)
def test_what_a_lean_that_would_not_show_makes_of_a_value_is_not_counted(
    lean: float, off: float, *, is_untold: bool
) -> None:
    """It is said that 12 arcsec show, and that a smaller lean moves a value by 5 sigma."""
    said = [{"step": "dwell_03.mcap", "position": 3, "lean_arcsec": 12.0, "sigmas": 5.0}]
    found = untold_by_size(said, {"dwell_03": lean * RAD_PER_ARCSEC}, {"accelerometer E yx": off})
    assert found == ({"accelerometer E yx": "dwell_03 stood 7 arcsec off, where 12 show"} if is_untold else {})
    assert not untold_by_size(said, {"dwell_04": lean * RAD_PER_ARCSEC}, {"accelerometer E yx": off})


def test_gyroscopes_count_unless_a_cube_stood_off_its_marks_by_far_more_than_is_stated() -> None:
    assert not untold_by_heading({}, 1e-3)
    assert not untold_by_heading({"dwell_01": 4e-3}, 1e-3)
    found = untold_by_heading({"dwell_01": 1e-4, "dwell_04": 7e-3}, 1e-3)
    assert set(found) == {f"gyroscope {name}" for name in VALUES}
    assert set(found.values()) == {"dwell_04 stood 0.40 deg off its marks, which are said to be met to 0.057"}

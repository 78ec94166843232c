"""What is not counted, and only where the program said so."""

from tests.year.lone_dwells import untold_values

SAID = ["alone with their face up: positions 3, 10; no second dwell shows whether"]


def test_the_level_sensors_of_a_dwell_said_to_be_alone_are_not_counted_where_it_stood_askew() -> None:
    untold = untold_values(SAID, {"dwell_03": 4e-5, "dwell_01": 4e-5})
    assert set(untold) == {"accelerometer E yx", "accelerometer E zx"}
    assert set(untold_values(SAID, {"dwell_10": 4e-5})) == {"accelerometer E xz", "accelerometer E yz"}


def test_what_the_program_did_not_say_counts() -> None:
    assert not untold_values([], {"dwell_03": 4e-5})
    assert not untold_values(SAID, {"dwell_01": 4e-5})


def test_what_a_seat_scatters_by_counts_and_so_does_what_the_dwells_contradict() -> None:
    for lean in (0.0, 1e-5, 2e-4):
        assert not untold_values(SAID, {"dwell_03": lean})


def test_where_nothing_checks_a_position_no_seat_contradicts_it() -> None:
    leans = {"dwell_03": 2e-4, "dwell_10": 2e-4}
    assert not untold_values(SAID, leans)
    unchecked = [*SAID, "nothing checks position 3: all that was counted there"]
    misalignments = {"accelerometer E yx", "accelerometer E zx"}
    assert set(untold_values(unchecked, leans)) == misalignments | {"accelerometer k y", "accelerometer k z"}
    assert set(untold_values(unchecked, {"dwell_03": 4e-5})) == misalignments

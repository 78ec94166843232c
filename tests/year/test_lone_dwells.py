"""What is not counted, and only where the program said so."""

from tests.year.lone_dwells import untold_values

SAID = ["alone with their face up: positions 3, 10; no second dwell shows whether"]


def test_the_level_sensors_of_a_dwell_said_to_be_alone_are_not_counted_where_it_stood_askew() -> None:
    untold = untold_values(SAID, {"dwell_03": 4e-5, "dwell_01": 4e-5})
    assert set(untold) == {"accelerometer E yx", "accelerometer E zx"}
    assert set(untold_values(SAID, {"dwell_10": 4e-5})) == {"accelerometer E xz", "accelerometer E yz"}


def test_what_moves_from_and_to_it_tell_of_the_gyroscope_is_not_counted_where_the_program_says_so() -> None:
    said = [SAID[0] + ", as do gyroscope scale factor and misalignment by the moves from and to it; record"]
    assert {"gyroscope k z", "gyroscope E xy"} < set(untold_values(said, {"dwell_03": 4e-5}))
    assert not [name for name in untold_values(said, {"dwell_03": 4e-5}) if "gyroscope D" in name]


def test_a_sensor_that_passed_few_counts_leaves_as_much_untold_as_its_interval_is_wide() -> None:
    few = (
        "position 3: accelerometer z shows one count edge; its rate is only known to lie in [-0.21, 0.009] count/s"
    )
    assert untold_values([*SAID, few], {"dwell_03": 1.4e-4})
    assert not untold_values([*SAID, few], {"dwell_03": 2.5e-4})
    assert not untold_values([*SAID, few], {"dwell_10": 1.4e-4})


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

"""What rests and moves say, as text."""

from station.results.diagnosis.rests_and_moves_said import rests_and_moves_lines


def test_rests_say_how_many_how_long_and_by_how_much_they_are_off_gravity() -> None:
    rests = [
        {"name": "a", "seconds": 2.0, "specific_force_less_gravity_g": 3e-3},
        {"name": "b", "seconds": 8.25, "specific_force_less_gravity_g": -1e-3},
        {"name": "c", "seconds": 3.0},
    ]
    [said] = rests_and_moves_lines({"rests": rests})
    assert said == "3 rests of 2.0 to 8.2 s, specific force off gravity by 2.24 mg rms"
    assert list(rests_and_moves_lines({"rests": rests[2:]})) == ["1 rests of 3.0 to 3.0 s"]

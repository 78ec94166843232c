"""What goes by time shows in its own triad; a cube that tilts shows in the accelerometers."""

from procedures.diagnosis.walk_rivals import BY_TIME, triad_of
from procedures.effects import EFFECTS


def test_what_goes_by_time_shows_in_its_own_triad_and_a_tilt_in_the_accelerometers() -> None:
    shown = {each.name: triad_of(each) for each in EFFECTS if each.name.endswith(BY_TIME)}
    assert shown["gyroscope.bias_drift"] == shown["gyroscope.jump"] == "gyroscope"
    assert shown["accelerometer.bias_settling"] == shown["placement.tilt"] == "accelerometer"
    assert all(triad == name.partition(".")[0] or name == "placement.tilt" for name, triad in shown.items())

"""A reference is an angle or a rate by its name."""

import pytest

from station.files.logs.angle_names import degrees_per_angle


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("enc_deg", 1.0), ("Angle [deg]", 1.0), ("theta", 1.0), ("motor_position", 1.0),
        ("table_rad", 57.29577951308232),
        ("motor (turns)", 360.0), ("encoder_arcsec", 1 / 3600), ("rate_ref_deg_s", None), ("ref", None),
        ("position_rate_deg_s", None), ("encoder_speed", None), ("omega_table", None), ("table [deg/s]", None),
        ("theta_dot", None), ("thetaDot", None), ("dtheta_dt", None), ("TableVel_deg", None), ("ANGLE_RATE", None),
        ("angle_rate2", None), ("integrated_angle_deg", 1.0), ("calibrated_theta", 1.0),
        ("level_rad", 57.29577951308232), ("travel_angle", 1.0), ("separate_position", 1.0),
    ],
)  # fmt: skip
def test_which_references_are_angles(name: str, expected: float | None) -> None:
    assert degrees_per_angle(name) == (None if expected is None else pytest.approx(expected))

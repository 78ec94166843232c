"""Headers of loggers, as found in public repositories, and what is guessed of them."""

import pytest

from station.files.logs.header_guesses import (
    degrees_per_angle,
    guessed_temperature,
    guessed_time,
    time_unit_in_name,
)
from station.files.logs.triad_guesses import guessed_triad, sensors_without_axis

HEADERS = [
    ("timestamp_us,acc_x,acc_y,acc_z,temp_degC", "timestamp_us", "", "acc_x acc_y acc_z", "temp_degC"),
    ("t_s,gx,gy,gz,ax,ay,az,temp_c", "t_s", "gx gy gz", "ax ay az", "temp_c"),
    ("Time,AccX,AccY,AccZ,GyrX,GyrY,GyrZ,Temp", "Time", "GyrX GyrY GyrZ", "AccX AccY AccZ", "Temp"),
    ("time [ms],gyro.x,gyro.y,gyro.z", "time [ms]", "gyro.x gyro.y gyro.z", "", None),
    ("w_x,w_y,w_z,f_x,f_y,f_z", None, "w_x w_y w_z", "f_x f_y f_z", None),
    ("stamp,angular_velocity_x,angular_velocity_y,angular_velocity_z", None,
     "angular_velocity_x angular_velocity_y angular_velocity_z", "", None),
    ("imu_timestamp,linear_acceleration_x,linear_acceleration_y,linear_acceleration_z", "imu_timestamp", "",
     "linear_acceleration_x linear_acceleration_y linear_acceleration_z", None),
    ("t,omega_z,temperature", "t", "- - omega_z", "", "temperature"),
    ("Zeit [s];Drehrate z [°/h];Temperatur [°C]".replace(";", ","), "Zeit [s]", "- - Drehrate z [°/h]", "",
     "Temperatur [°C]"),
    ("log.time,log.acc:1,log.acc:2,log.acc:3,log.temp", "log.time", "",
     "log.acc:1 log.acc:2 log.acc:3", "log.temp"),
    ("time,gyroRotationX(rad/s),accelerometerAccelerationZ(G)", "time", "gyroRotationX(rad/s) - -",
     "- - accelerometerAccelerationZ(G)", None),
    ("GPS TFlags,GPS Week,GPS TOW,X Gyro [x8005],Y Gyro [x8005],Z Gyro [x8005]", "GPS TOW",
     "X Gyro [x8005] Y Gyro [x8005] Z Gyro [x8005]", "", None),
    ("ms,gx,gy,gz", "ms", "gx gy gz", "", None),
    ("t,gx,gy,gz,T", "t", "gx gy gz", "", "T"),
    ("T,gx,gy,gz", "T", "gx gy gz", "", None),
    ("t,gyro_data_x,gyro_data_y,gyro_data_z,ax_cm_s2,ay_cm_s2,az_cm_s2", "t",
     "gyro_data_x gyro_data_y gyro_data_z", "ax_cm_s2 ay_cm_s2 az_cm_s2", None),
    ("min,max,ax,ay,az", None, "", "ax ay az", None),
    ("lon,lat,height,speed", None, "", "", None),
]  # fmt: skip


@pytest.mark.parametrize(("header", "time", "gyro", "accel", "temperature"), HEADERS)
def test_roles_of_columns(header: str, time: str | None, gyro: str, accel: str, temperature: str | None) -> None:
    names = header.split(",")
    assert guessed_time(names) == time
    assert guessed_temperature(names) == temperature
    for triad, expected in (("gyroscope", gyro), ("accelerometer", accel)):
        found = guessed_triad(names, triad)
        assert " ".join(name or "-" for name in found if any(found)) == expected


@pytest.mark.parametrize(
    ("header", "expected"),
    [("t,rate [deg/h]", "rate [deg/h]"), ("t_s,fog_deg_h,temp", "fog_deg_h"), ("t,gyro_deg_h", "gyro_deg_h"),
     ("t,imu.gyro_dps", "imu.gyro_dps"), ("t,ref_rate_deg_s", None), ("t,fog_deg_h,gyro_deg_h", None),
     ("t,rate", None), ("t,heading_deg_s", None), ("t,table_rate_dps", None), ("t,cmd_rate_dps,v", None)],
)  # fmt: skip
def test_a_gyroscope_without_an_axis_is_guessed_where_it_is_the_only_one(
    header: str, expected: str | None
) -> None:
    found = sensors_without_axis(header.split(","), "gyroscope")
    assert (found[0] if len(found) == 1 else None) == expected


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("ms", "ms"), ("us", "us"), ("[s]", "s"), ("min", None), ("t_ms", "ms"), ("TimeUS", "us"),
        ("time_usec", "us"),
        ("timestamp (ms)", "ms"), ("Zeit [h]", "h"), ("time_days", "days"), ("time (d)", "days"), ("micros", "us"),
        ("datenum", "matlab"), ("time_hhmmss", "hhmmss"), ("time [hh:mm:ss]", "hhmmss"), ("epoch [ms]", "ms"),
        ("time [unix_ms]", "unix-ms"), ("tow(msec)", "ms"), ("elapsed (s)", "s"), ("excel_time", "excel"),
        ("timestamp", None), ("time", None), ("SampleTimeFine", None), ("temp_min", None), ("t [degC]", None),
    ],
)  # fmt: skip
def test_units_of_time_in_names(name: str, unit: str | None) -> None:
    found = time_unit_in_name(name)
    assert (found and found.name) == unit


@pytest.mark.parametrize(
    ("name", "seconds"),
    [("t [0.1 ms]", 1e-4), ("time [100us]", 1e-4), ("time [tick:1e-4]", 1e-4), ("HostTicks [100 ns]", 1e-7)],
)
def test_ticks_in_names(name: str, seconds: float) -> None:
    found = time_unit_in_name(name)
    assert found is not None
    assert found.seconds == pytest.approx(seconds)


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

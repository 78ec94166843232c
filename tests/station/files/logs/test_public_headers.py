"""Headers as public programs and devices write them: which columns are time, gyroscopes and accelerometers."""

from pathlib import Path

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.logs.header_guesses import guessed_time
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.logs.triad_guesses import guessed_triad
from station.files.tables.reader import read_table
from tests.refusals import refused

HEADERS = {  # name: header, time, the first gyroscope's and accelerometer's column
    "phyphox, gyroscope": ("Time (s),Gyroscope x (rad/s),Gyroscope y (rad/s),Gyroscope z (rad/s),Absolute (rad/s)",
                           "Time (s)", "Gyroscope x (rad/s)", None),
    "phyphox, acceleration": ("Time (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2),"
                              "Absolute acceleration (m/s^2)", "Time (s)", None, "Acceleration x (m/s^2)"),
    "phyphox, both accelerations": ("Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2),"
                                    "Linear Acceleration z (m/s^2),Acceleration x (m/s^2),Acceleration y (m/s^2),"
                                    "Acceleration z (m/s^2)", "Time (s)", None, "Acceleration x (m/s^2)"),
    "Physics Toolbox": ("time,ax,ay,az,wx,wy,wz", "time", "wx", "ax"),
    "SensorLog, accelerometer": (
        "loggingTime(txt),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),"
        "accelerometerAccelerationY(G),accelerometerAccelerationZ(G),gyroRotationX(rad/s),gyroRotationY(rad/s),"
        "gyroRotationZ(rad/s)",
        "accelerometerTimestamp_sinceReboot(s)", "gyroRotationX(rad/s)", "accelerometerAccelerationX(G)"),
    "SensorLog, motion without gravity": (
        "motionTimestamp_sinceReboot(s),motionRotationRateX(rad/s),motionRotationRateY(rad/s),"
        "motionRotationRateZ(rad/s),motionUserAccelerationX(G),motionUserAccelerationY(G),motionUserAccelerationZ(G)",
        "motionTimestamp_sinceReboot(s)", "motionRotationRateX(rad/s)", None),
    "VectorNav": ("TimeStartup,UncompAccelX,UncompAccelY,UncompAccelZ,UncompGyroX,UncompGyroY,UncompGyroZ",
                  "TimeStartup", "UncompGyroX", "UncompAccelX"),
    "Betaflight": ("loopIteration,time,axisP[0],gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],"
                   "accSmooth[2]", "time", "gyroADC[0]", "accSmooth[0]"),
    "PX4, sensor_combined": (
        "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,"
        "accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2]",
        "timestamp", "gyro_rad[0]", "accelerometer_m_s2[0]"),
    "ArduPilot": ("TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T", "TimeUS", "GyrX", "AccX"),
    "ROS, rostopic echo": (
        "time,field.header.seq,field.header.stamp,field.orientation.x,field.angular_velocity.x,"
        "field.angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,"
        "field.linear_acceleration.y,field.linear_acceleration.z",
        "time", "field.angular_velocity.x", "field.linear_acceleration.x"),
    "EuRoC": ("timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
              "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]", "timestamp [ns]", "w_RS_S_x [rad s^-1]", "a_RS_S_x [m s^-2]"),
    "Analog Devices": ("TIMESTAMP,X_GYRO_OUT,Y_GYRO_OUT,Z_GYRO_OUT,X_ACCL_OUT,Y_ACCL_OUT,Z_ACCL_OUT,TEMP_OUT",
                       "TIMESTAMP", "X_GYRO_OUT", "X_ACCL_OUT"),
    "ST AlgoBuilder": ("Time [ms],Acc_X [mg],Acc_Y [mg],Acc_Z [mg],Gyro_X [mdps],Gyro_Y [mdps],Gyro_Z [mdps]",
                       "Time [ms]", "Gyro_X [mdps]", "Acc_X [mg]"),
    "Shimmer": ("Timestamp_Unix_CAL,Accel_LN_X_CAL,Accel_LN_Y_CAL,Accel_LN_Z_CAL,Gyro_X_CAL,Gyro_Y_CAL,Gyro_Z_CAL",
                "Timestamp_Unix_CAL", "Gyro_X_CAL", "Accel_LN_X_CAL"),
    "MicroStrain": ("Time,scaledAccelX [g],scaledAccelY [g],scaledAccelZ [g],scaledGyroX [rad/s],"
                    "scaledGyroY [rad/s],scaledGyroZ [rad/s]", "Time", "scaledGyroX [rad/s]", "scaledAccelX [g]"),
    "Inertial Sense": ("time,pqr[0],pqr[1],pqr[2],acc[0],acc[1],acc[2]", "time", "pqr[0]", "acc[0]"),
    "NovAtel": ("Week,GNSSTime,X_Accel,Y_Accel,Z_Accel,X_Gyro,Y_Gyro,Z_Gyro", "GNSSTime", "X_Gyro", "X_Accel"),
}  # fmt: skip


@pytest.mark.parametrize("program", HEADERS)
def test_columns_of_public_programs(program: str) -> None:
    header, time, gyro, accel = HEADERS[program]
    names = header.split(",")
    assert guessed_time(names) == time
    for triad, first in (("gyroscope", gyro), ("accelerometer", accel)):
        found = guessed_triad(names, triad)
        assert found[0] == first
        if first is not None:
            at = names.index(first)
            assert found == names[at : at + 3]


@pytest.mark.parametrize(
    ("name", "triad", "unit", "has_gravity"),
    [("Gyroscope.csv", "gyro", "rad/s", True), ("TotalAcceleration.csv", "accel", "m/s2", True),
     ("Accelerometer.csv", "accel", "m/s2", False)],
)  # fmt: skip
def test_sensor_logger_writes_z_y_x_and_the_file_says_of_what(
    name: str, triad: str, unit: str, has_gravity: bool, tmp_path: Path
) -> None:
    rows = [f"{1760000000000000000 + 10000000 * i},{0.01 * i:.6f},{3.3 + i % 2},{2.2},{1.1}" for i in range(40)]
    (tmp_path / name).write_text("\n".join(["time,seconds_elapsed,z,y,x", *rows]))
    found = choose_columns(read_table(tmp_path / name), ColumnOptions(rate_hz=100))
    assert getattr(found, triad) == ("x", "y", "z")
    assert getattr(found, f"unit_{triad}") == unit
    assert any("no gravity" in guess for guess in found.guesses) != has_gravity


def test_bare_columns_in_a_file_that_says_no_sensor_are_asked_for(tmp_path: Path) -> None:
    rows = "\n".join(f"{i},{i % 3},{i % 2},{9.81}" for i in range(40))
    (tmp_path / "log7.csv").write_text(f"timestamp,x,y,z\n{rows}\n")
    with refused(DataRefused, None, "--gyro"):
        choose_columns(read_table(tmp_path / "log7.csv"), ColumnOptions(rate_hz=100))


def test_phyphox_writes_quotes_and_semicolons_with_decimal_commas(tmp_path: Path) -> None:
    header = '"Time (s)";"Gyroscope x (rad/s)";"Gyroscope y (rad/s)";"Gyroscope z (rad/s)"'
    rows = "\n".join(f"{i / 100:.9E};{1e-3 * (i % 5):.9E};{-2e-3:.9E};{3e-3 + 1e-5 * i:.9E}".replace(".", ",")
                     for i in range(300))  # fmt: skip
    (tmp_path / "Gyroscope.csv").write_text(f"{header}\n{rows}\n")
    table = read_table(tmp_path / "Gyroscope.csv")
    assert list(table.columns)[1] == "Gyroscope x (rad/s)"
    assert np.allclose(table.columns["Time (s)"], np.arange(300) / 100)

"""Headers as loggers, phones and laboratories write them: which columns are which sensor, and in which unit."""

from pathlib import Path

import numpy as np
import pytest

from station.files.logs.header_guesses import split_unit
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.logs.triad_guesses import guessed_triad, sensor_of_unit, sensors_without_axis, unit_of_triad
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, unit_named
from station.files.tables.reader import read_table

HEADERS = [  # names, gyroscopes, accelerometers
    ("Time (s);Gx (g);Gy (g);Gz (g)", "", "Gx (g);Gy (g);Gz (g)"),
    ("t;gx [g];gy [g];gz [g];wx [deg/s];wy [deg/s];wz [deg/s]", "wx [deg/s];wy [deg/s];wz [deg/s]",
     "gx [g];gy [g];gz [g]"),
    ("t;ax [deg/s];ay [deg/s];az [deg/s]", "ax [deg/s];ay [deg/s];az [deg/s]", ""),
    ("t;Gx [mdps];Gy [mdps];Gz [mdps]", "Gx [mdps];Gy [mdps];Gz [mdps]", ""),
    ("t;x (m/s^2);y (m/s^2);z (m/s^2)", "", "x (m/s^2);y (m/s^2);z (m/s^2)"),
    ("t;X [mg];Y [mg];Z [mg]", "", "X [mg];Y [mg];Z [mg]"),
    ("t;gx_g;gy_g;gz_g", "", "gx_g;gy_g;gz_g"),
    ("time;gFx (g);gFy (g);gFz (g);wx (rad/s);wy (rad/s);wz (rad/s)", "wx (rad/s);wy (rad/s);wz (rad/s)",
     "gFx (g);gFy (g);gFz (g)"),
    ("Time (s);Acceleration x (m/s^2);Acceleration y (m/s^2);Acceleration z (m/s^2)", "",
     "Acceleration x (m/s^2);Acceleration y (m/s^2);Acceleration z (m/s^2)"),
    ("Time (s);Gyroscope x (rad/s);Gyroscope y (rad/s);Gyroscope z (rad/s)",
     "Gyroscope x (rad/s);Gyroscope y (rad/s);Gyroscope z (rad/s)", ""),
    ("t;Mx (uT);My (uT);Mz (uT)", "", ""),
    ("t;mag_x (G);mag_y (G);mag_z (G);ax (G);ay (G);az (G)", "", "ax (G);ay (G);az (G)"),
    ("t;gx (uT);gy (uT);gz (uT)", "", ""),
    ("t;gx (deg);gy (deg);gz (deg)", "", ""),  # angles
    ("t;gx (LSB);gy (LSB);gz (LSB);ax (LSB);ay (LSB);az (LSB)", "gx (LSB);gy (LSB);gz (LSB)",
     "ax (LSB);ay (LSB);az (LSB)"),
    ("t;Gx (g);Gy;Gz", "", "Gx (g);Gy;Gz"),  # the unit stands once
    ("t;Gyr_X [°/s];Gyr_Y [°/s];Gyr_Z [°/s];Acc_X [m/s²];Acc_Y [m/s²];Acc_Z [m/s²]",
     "Gyr_X [°/s];Gyr_Y [°/s];Gyr_Z [°/s]", "Acc_X [m/s²];Acc_Y [m/s²];Acc_Z [m/s²]"),
    ("t;X-axis acceleration [g];Y-axis acceleration [g];Z-axis acceleration [g]", "",
     "X-axis acceleration [g];Y-axis acceleration [g];Z-axis acceleration [g]"),
    ("t;Accel(g) X;Accel(g) Y;Accel(g) Z;Gyro(dps) X;Gyro(dps) Y;Gyro(dps) Z",
     "Gyro(dps) X;Gyro(dps) Y;Gyro(dps) Z", "Accel(g) X;Accel(g) Y;Accel(g) Z"),
    ("t;a_x / g;a_y / g;a_z / g", "", "a_x / g;a_y / g;a_z / g"),
    ("t;a_x/(m/s^2);a_y/(m/s^2);a_z/(m/s^2)", "", "a_x/(m/s^2);a_y/(m/s^2);a_z/(m/s^2)"),
    ("t;p [rad/s];q [rad/s];r [rad/s]", "p [rad/s];q [rad/s];r [rad/s]", ""),
    ("t;roll rate (deg/s);pitch rate (deg/s);yaw rate (deg/s)",
     "roll rate (deg/s);pitch rate (deg/s);yaw rate (deg/s)", ""),
    ("t;acceleration (x) [m/s2];acceleration (y) [m/s2];acceleration (z) [m/s2]", "",
     "acceleration (x) [m/s2];acceleration (y) [m/s2];acceleration (z) [m/s2]"),
    ("t;imu0.ax [mg];imu0.ay [mg];imu0.az [mg];imu0.gx;imu0.gy;imu0.gz", "imu0.gx;imu0.gy;imu0.gz",
     "imu0.ax [mg];imu0.ay [mg];imu0.az [mg]"),
    ("t;ref_x (deg/s);table_z [deg/s]", "", ""),
    ("t;angular_velocity.x;angular_velocity.y;angular_velocity.z;linear_acceleration.x;linear_acceleration.y;"
     "linear_acceleration.z", "angular_velocity.x;angular_velocity.y;angular_velocity.z",
     "linear_acceleration.x;linear_acceleration.y;linear_acceleration.z"),
    ("t;pos_x [m];pos_y [m];pos_z [m];vel_x [m/s];vel_y [m/s];vel_z [m/s]", "", ""),
    ("t;ax [m/s];ay [m/s];az [m/s]", "", ""),  # velocity increments
    ("t;nx [g];ny;nz;wx [deg/s];wy;wz", "wx [deg/s];wy;wz", "nx [g];ny;nz"),  # load factors
    ("t;Nx (g);Ny (g);Nz (g);p [deg/s];q;r", "p [deg/s];q;r", "Nx (g);Ny (g);Nz (g)"),
    ("t;nx_g;ny_g;nz_g", "", "nx_g;ny_g;nz_g"),
    ("t;ax [m/s^2];y;z", "", "ax [m/s^2];y;z"),  # the word stands once, too
    ("t;Accel X (g);Y;Z;Gyro X (deg/s);Y_2;Z_2", "Gyro X (deg/s);Y_2;Z_2", "Accel X (g);Y;Z"),
    ("t;roll_rate [deg/s];pitch_rate;yaw_rate;xacc [mg];yacc;zacc", "roll_rate [deg/s];pitch_rate;yaw_rate",
     "xacc [mg];yacc;zacc"),
    ("t;nx;ny;nz [g]", "", "nx;ny;nz [g]"),
    ("t;Bx [G];By;Bz;rx [rad/s];ry;rz", "rx [rad/s];ry;rz", ""),
    ("t;mx [uT];y;z", "", ""),
    ("t;vx [m/s];y;z;Vx [m/s];Vy;Vz", "", ""),
    ("t;max [g];y", "", ""),
    ("t;motionGravityX(G);motionGravityY(G);motionGravityZ(G)", "", ""),  # a filter's
    ("t;nx;ny;nz", "", ""),
    ("t;w_ib_b_x_deg_per_s;w_ib_b_y_deg_per_s;w_ib_b_z_deg_per_s",
     "w_ib_b_x_deg_per_s;w_ib_b_y_deg_per_s;w_ib_b_z_deg_per_s", ""),
    ("t;gyro_dps_x;gyro_dps_y;gyro_dps_z;acc_mg_x;acc_mg_y;acc_mg_z", "gyro_dps_x;gyro_dps_y;gyro_dps_z",
     "acc_mg_x;acc_mg_y;acc_mg_z"),
    ("t;gyroXRadPerSec;gyroYRadPerSec;gyroZRadPerSec", "gyroXRadPerSec;gyroYRadPerSec;gyroZRadPerSec", ""),
    ("t;Wx, deg/h;Wy, deg/h;Wz, deg/h", "Wx, deg/h;Wy, deg/h;Wz, deg/h", ""),
    ("t;imu_g_x;imu_g_y;imu_g_z;vx_m_s;vy_m_s;vz_m_s", "imu_g_x;imu_g_y;imu_g_z", ""),
]  # fmt: skip


@pytest.mark.parametrize(("header", "gyro", "accel"), HEADERS, ids=[each[0][:40] for each in HEADERS])
def test_a_stated_unit_decides_the_kind_of_sensor(header: str, gyro: str, accel: str) -> None:
    names = header.split(";")
    for triad, expected in (("gyroscope", gyro), ("accelerometer", accel)):
        found = guessed_triad(names, triad)
        assert ";".join(name or "-" for name in found if any(found)) == expected


@pytest.mark.parametrize("written", ["{}:{n}", "{}_{axis}", "{}[{i}]", "log.{}:{n}", "{}.{axis}"])
@pytest.mark.parametrize(
    ("gyro", "accel", "units"),
    [("gyr_dps", "acc_g", ("deg/s", "g")), ("gyro_deg_s", "accel_g", ("deg/s", "g")),
     ("w_dps", "a_g", ("deg/s", "g")),
     ("omega_rad_s", "f_g", ("rad/s", "g")), ("angular_rate_deg_h", "specific_force_mg", ("deg/h", "mg")),
     ("imu_g", "imu_a", (None, None)), ("UncompGyro", "UncompAcc", (None, None)),
     ("6286.14:scaledGyro", "6286.14:scaledAccel", (None, None))],
)  # fmt: skip
def test_an_accelerometer_is_none_of_rate_in_whatever_container(
    gyro: str, accel: str, units: tuple[str | None, str | None], written: str
) -> None:
    named = {
        each: [written.format(each, axis=axis, i=i, n=i + 1) for i, axis in enumerate("xyz")]
        for each in (accel, gyro)
    }
    names = ["t", *named[accel], *named[gyro]]
    for triad, name, unit, known in (
        ("gyroscope", gyro, units[0], GYRO_UNITS), ("accelerometer", accel, units[1], ACCEL_UNITS)
    ):  # fmt: skip
        found = guessed_triad(names, triad)
        assert found in (named[name], [None] * 3)  # what is not understood is asked for
        if written in {"{}:{n}", "{}_{axis}", "{}[{i}]"}:
            assert found == named[name]
            assert unit_of_triad(names, found, known) == unit


@pytest.mark.parametrize(
    ("columns", "found"),
    [((1, 2, 3), (1, 2, 3)), ((0, 1, 2), (0, 1, 2)), ((4, 5, 6), None), ((1, 2, 4), None)],
)
def test_numbers_of_columns_are_axes_of_a_matrix_of_three_alone(
    columns: tuple[int, ...], found: tuple[int, ...] | None
) -> None:
    names = [f"gyro:{i}" for i in columns]
    expected = [None] * 3 if found is None else [f"gyro:{i}" for i in found]
    assert guessed_triad(names, "gyroscope") == expected


@pytest.mark.parametrize(
    "name",
    ["acc_w_{}", "a_w_{}", "f_w_{}", "mag_g_{}", "vel_w_{}", "gyro_a_{}", "gyro_f_{}", "ang_acc_{}", "pos_w_{}",
     "gyro_bias_{}", "accel_bias_{}", "gyro_bias_{}_deg_s", "accel_bias_{}_m_s2", "std_g{}", "gyro_offset_{}",
     "angular_acceleration_{}", "motionUserAcceleration{}"],
)  # fmt: skip
def test_a_letter_next_to_a_word_and_an_estimate_are_no_sensor(name: str) -> None:
    for names in ([name.format(axis) for axis in "xyz"], [f"{name.format('q')}:{i}" for i in (1, 2, 3)]):
        assert not any((*guessed_triad(names, "gyroscope"), *guessed_triad(names, "accelerometer")))


def test_estimates_next_to_outputs_leave_these_and_gravity_is_preferred() -> None:
    names = [
        f"{each}_{axis}" for each in ("gyro_bias", "gyro", "Accelerometer", "TotalAcceleration") for axis in "xyz"
    ]
    assert guessed_triad(names, "gyroscope") == ["gyro_x", "gyro_y", "gyro_z"]
    assert guessed_triad(names, "accelerometer") == [f"TotalAcceleration_{axis}" for axis in "xyz"]
    assert guessed_triad(["bias_corrected_gx"], "gyroscope")[0] == "bias_corrected_gx"
    assert sensors_without_axis(["gyro_bias_deg_s", "fog_deg_s"], "gyroscope") == ["fog_deg_s"]


@pytest.mark.parametrize(
    ("header", "unit"),
    [("nx [g];ny;nz", "g"), ("ax [m/s^2];y;z", "m/s2"), ("Ax (mg);Ay (mg);Az (mg)", "mg"),
     ("ax [LSB];ay;az", "raw"), ("ax [g];ay [mg];az", None), ("ax;ay;az", None)],
)  # fmt: skip
def test_a_unit_that_stands_once_is_that_of_the_triad(header: str, unit: str | None) -> None:
    names = header.split(";")
    assert unit_of_triad(["t", *names], names, ACCEL_UNITS) == unit


UNITS = [
    ("deg/s", "dps °/s º/s deg/sec degree/s degrees/s degrees/second deg·s⁻¹ °·s^-1 deg*s^-1 degpersec DPS Deg/S"),
    ("rad/s", "rad/s radians/s rad/second rad·s⁻¹ rad*s^-1 (rad/s) Rad/Sec"),
    ("mdeg/s", "mdps mdeg/s millideg/s"), ("deg/h", "deg/h °/h deg/hr deg/hour degrees/hour dph"),
    ("m/s2", "m/s^2 m/s² m/s2 m/s/s ms^-2 m·s⁻² m*s^-2 m/sec^2 m/sec² meters/second^2 m/(s*s) m/(s^2) mps2"),
    ("g", "g G gee gs g0 gn g-force"), ("mg", "mg mG milli-g millig"), ("ug", "ug µg μg"),  # noqa: RUF001
    ("cm/s2", "cm/s^2 cm/s² gal Gal"), ("raw", "LSB counts raw ADC digits"),
]  # fmt: skip


@pytest.mark.parametrize(("unit", "written"), [(unit, each) for unit, all_ in UNITS for each in all_.split()])
def test_a_unit_as_people_write_it(unit: str, written: str) -> None:
    assert unit_named(written) == unit
    assert split_unit(f"ax [{written}]") == ("ax", unit)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("Gx (g)", "accelerometer"), ("ax [deg/s]", "gyroscope"), ("gx", None), ("gx (LSB)", None), ("mx (uT)", ""),
     ("ax_m_s2", "accelerometer"), ("t (s)", None), ("gx (furlong)", None), ("angle_deg", None)],
)  # fmt: skip
def test_what_a_unit_decides(name: str, kind: str | None) -> None:
    assert sensor_of_unit(name) == kind


@pytest.mark.parametrize(
    ("header", "named"),
    [("t,gx,gy,gz,A1,A2,A3", "--accel"), ("t,ax,ay,az,w1,w2,w3", "--gyro"), ("t,gx,gy,gz,fan", "")],
)
def test_columns_that_may_be_the_missing_triad_name_its_option(header: str, named: str, tmp_path: Path) -> None:
    rows = np.column_stack((np.arange(40) / 20, np.random.default_rng(1).standard_normal((40, header.count(",")))))
    np.savetxt(file := tmp_path / "log.csv", rows, delimiter=",", header=header, comments="")
    (hint,) = [guess for guess in choose_columns(read_table(file), ColumnOptions()).guesses if "not used" in guess]
    assert [option for option in ("--gyro", "--accel") if option in hint] == [named] * bool(named)

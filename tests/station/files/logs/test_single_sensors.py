"""Logs of one sensor, as fibre gyroscopes and laboratories write them: its unit says what it is."""

from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.logs.header_guesses import split_unit
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.tables.reader import read_table
from tests.refusals import refused

BEHIND = {
    "rate_deg_per_h": ("rate", "deg/h"), "rate_deg_per_hr": ("rate", "deg/h"),
    "rate_deg_per_hour": ("rate", "deg/h"),
    "bias_deg_h": ("bias", "deg/h"), "omega_z_rad_per_s": ("omega_z", "rad/s"), "wx_rad_sec": ("wx", "rad/s"),
    "wz_deg_per_sec": ("wz", "deg/s"), "gyro_degrees_per_second": ("gyro", "deg/s"), "fog_dps": ("fog", "deg/s"),
    "gyro_mdps": ("gyro", "mdeg/s"), "ax_mps2": ("ax", "m/s2"), "ax_m_s2": ("ax", "m/s2"),
    "ax_m_per_s2": ("ax", "m/s2"), "ax_m_per_s_2": ("ax", "m/s2"), "acc_ug": ("acc", "ug"),
    "acc_x_mg": ("acc_x", "mg"), "acc_micro_g": ("acc", "ug"), "acc_mg_x": ("acc_x", "mg"),
    "gyro_dps_z": ("gyro_z", "deg/s"), "accelerometer_m_s2[0]": ("accelerometer_x", "m/s2"),
    "GyroXDegPerSec": ("gyro_x", "deg/s"), "rateDegPerHour": ("rate", "deg/h"), "GyrX_DPS": ("gyrx", "deg/s"),
    "Rate deg/h": ("rate", "deg/h"), "Rate, deg/hr": ("rate", "deg/h"), "Rate: °/h": ("rate", "deg/h"),
    "Rate (raw) [deg/h]": ("rate_(raw)", "deg/h"), "deg/h": ("", "deg/h"),
    # words, and letters, that are no unit
    "temp_min": ("temp_min", ""), "imu_g_x": ("imu_g_x", ""), "upper_h": ("upper_h", ""),
    "gravity": ("gravity", ""), "super_s": ("super", "s"), "gyro_adc_x": ("gyro_adc_x", ""),
    "vel_m_per_s": ("vel", "m/s"), "vx_m_s": ("vx", "m/s"), "TimeUS": ("timeus", ""),
}  # fmt: skip


@pytest.mark.parametrize("name", BEHIND)
def test_a_unit_is_read_wherever_it_stands_in_a_name(name: str) -> None:
    assert split_unit(name) == BEHIND[name]


HEADERS = [  # header, the gyroscope and its unit, the accelerometer and its unit
    ("Elapsed (s);FOG out (deg/h);Coil RTD (degC)", "FOG out (deg/h)", "deg/h", None, None),
    ("t_s;rate_deg_per_h", "rate_deg_per_h", "deg/h", None, None),
    ("Time [s];Output [°/hr]", "Output [°/hr]", "deg/h", None, None),
    ("Zeit [s];Ausgang [°/h];Temperatur [°C]", "Ausgang [°/h]", "deg/h", None, None),
    ("Time (s);Bias (deg/hr);T board (C)", "Bias (deg/hr)", "deg/h", None, None),
    ("seconds_elapsed;DSP-1760 out, rad/s", "DSP-1760 out, rad/s", "rad/s", None, None),
    ("t_s;ch1_dph;coil_degC", "ch1_dph", "deg/h", None, None),
    ("t_s;QA2000 out (mg);case (degC)", None, None, "QA2000 out (mg)", "mg"),
    ("t_s;accel_ug;temp_c", None, None, "accel_ug", "ug"),
    ("t_s;FOG out (deg/h);vibration (g)", "FOG out (deg/h)", "deg/h", None, None),
]


def written(tmp_path: Path, header: str) -> Path:
    count = header.count(";") + 1
    rows = np.random.default_rng(1).standard_normal((60, count))
    rows[:, 0] = np.arange(60) / 20
    np.savetxt(
        file := tmp_path / "log.csv", rows, delimiter=";", header=header, comments="", fmt="%.6f", encoding="utf-8"
    )
    return file


@pytest.mark.parametrize(("header", "gyro", "unit_gyro", "accel", "unit_accel"), HEADERS)
def test_the_unit_says_what_a_single_sensor_is(
    header: str, gyro: str | None, unit_gyro: str | None, accel: str | None, unit_accel: str | None, tmp_path: Path
) -> None:
    found = choose_columns(read_table(written(tmp_path, header)), ColumnOptions())
    assert (found.gyro[0], found.unit_gyro) == (gyro, unit_gyro)
    assert (found.accel[0], found.unit_accel) == (accel, unit_accel)


@pytest.mark.parametrize(
    "header",
    [
        "t_s;table_rate_dps",
        "t_s;Sollrate [°/s]",
        "t_s;Input rate (deg/s)",
        "t_s;heading_deg_s",
        "t_s;fog_dph;rlg_dph",
    ],
)
def test_what_is_no_sensor_or_one_of_several_is_asked_for(header: str, tmp_path: Path) -> None:
    with refused(DataRefused, ErrorCode.COLUMNS, "--gyro"):
        choose_columns(read_table(written(tmp_path, header)), ColumnOptions())


def test_sensors_that_are_numbered_are_named_in_the_option(tmp_path: Path) -> None:
    with refused(DataRefused, ErrorCode.COLUMNS, "--gyro 'Gyro1 (deg/h),Gyro2 (deg/h),Gyro3 (deg/h)'"):
        choose_columns(
            read_table(written(tmp_path, "t_s;Gyro1 (deg/h);Gyro2 (deg/h);Gyro3 (deg/h)")), ColumnOptions()
        )


@pytest.mark.parametrize(("header", "is_named"), [("t;rate;temp", False), ("t;Vout;rate;temp", True)])
def test_a_rate_table_is_offered_only_where_an_output_would_be_left(
    header: str, is_named: bool, tmp_path: Path
) -> None:
    with pytest.raises(DataRefused) as caught:
        choose_columns(read_table(written(tmp_path, header)), ColumnOptions())
    assert ("--reference rate" in str(caught.value)) == is_named


def test_a_unit_in_the_name_of_a_stated_column_counts(tmp_path: Path) -> None:
    file = written(tmp_path, "t_s;rate_deg_per_h")
    found = choose_columns(read_table(file), ColumnOptions(gyro=("-", "-", "rate_deg_per_h")))
    assert (found.gyro, found.unit_gyro) == ((None, None, "rate_deg_per_h"), "deg/h")

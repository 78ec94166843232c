"""Logs to campaigns: what is guessed, what is refused, and the folder that reads back to the same numbers."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused, TimeUnitAsked
from station.files.campaign_folder.campaign_reading import read_campaign, read_for_solve
from station.files.logs.log_campaign import LogOptions, campaign_of_logs, write_campaign
from station.files.logs.log_columns import ColumnOptions
from tests.refusals import refused

N, PERIOD = 4000, 0.02


def soak(seed: int = 1, n: int = N) -> dict[str, FloatArray]:
    rng, t = np.random.default_rng(seed), PERIOD * np.arange(1, n + 1)
    accel, gyro = np.array([[[0.1, -0.2, 9.80]], [[0.0, 0.0, 0.0]]]) + 1e-3 * rng.standard_normal((2, n, 3))
    columns = {"t": t, **{f"g{a}": gyro[:, i] for i, a in enumerate("xyz")}}
    return {**columns, **{f"a{a}": accel[:, i] for i, a in enumerate("xyz")}, "temp": 25 + t / 60}


def save(file: Path, columns: dict[str, FloatArray], header: bool = True) -> Path:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join(columns)] if header else []
    file.write_text("\n".join([*lines, *(",".join(map(repr, row)) for row in rows)]) + "\n")
    return file


def test_a_log_with_a_header_needs_no_option_and_every_guess_is_shown(tmp_path: Path) -> None:
    found = campaign_of_logs([save(tmp_path / "log.csv", soak())], LogOptions())
    assert len(found.guesses) == 8
    imu = found.loaded.tables.imu
    assert (imu.unit_accel, imu.unit_gyro, imu.sample_period_s) == ("m/s2", None, pytest.approx(PERIOD))
    assert found.loaded.tables.site is None


def test_the_folder_written_reads_back_to_the_same_numbers(tmp_path: Path) -> None:
    log = save(tmp_path / "log.csv", soak() | {"fan": np.arange(N) % 7.0})
    stated = LogOptions(ColumnOptions(unit_gyro="dps", auxiliary=("fan",)), latitude_deg=48.1, serial="7")
    found = campaign_of_logs([log], stated)
    write_campaign(tmp_path / "c", found)
    read = read_campaign(tmp_path / "c")
    ours, theirs = found.loaded.campaign.soaks[0].series, read.campaign.soaks[0].series
    for name in ("t", "gyro", "accel", "temperature"):
        assert np.array_equal(getattr(ours, name), getattr(theirs, name)), name
    assert np.array_equal(ours.extra["aux_fan"], theirs.extra["aux_fan"])
    assert read.campaign.nominal_scale == found.loaded.campaign.nominal_scale
    assert read.tables == found.loaded.tables
    assert read.warnings == found.loaded.warnings


def test_one_sensor_alone_and_columns_by_number(tmp_path: Path) -> None:
    columns = soak()
    log = save(tmp_path / "fog.txt", {"rate": columns["gx"], "temp": columns["temp"]}, header=False)
    stated = ColumnOptions(gyro=("-", "-", "1"), accel=(), temperature="2", unit_gyro="deg/h", rate_hz=50.0)
    found = campaign_of_logs([log], LogOptions(stated))
    series = found.loaded.campaign.soaks[0].series
    assert series.accel is None
    assert series.gyro is not None
    assert np.array_equal(series.gyro[:, 2], columns["gx"])
    assert not series.gyro[:, :2].any()
    assert series.period == pytest.approx(0.02)


def test_rows_without_a_number_are_lost_samples(tmp_path: Path) -> None:
    columns = soak()
    columns["ax"][100:104] = np.nan
    found = campaign_of_logs([save(tmp_path / "log.csv", columns)], LogOptions())
    assert "line 102" in found.notes[0]
    assert any("0.1 s" in warning for warning in found.loaded.warnings)


@pytest.mark.parametrize(("bracket", "unit"), [("mV", "mV"), ("V", "V"), ("x8005", ""), ("0x51", ""), ("7", "")])
def test_a_number_in_brackets_is_no_unit(tmp_path: Path, bracket: str, unit: str) -> None:
    log = save(tmp_path / "log.csv", {f"gyro z [{bracket}]": soak()["gz"], "t": soak()["t"]})
    stated = LogOptions(ColumnOptions(gyro=("-", "-", "1")))
    assert campaign_of_logs([log], stated).loaded.output_name == unit


def test_a_gap_is_named_by_the_line_of_the_file(tmp_path: Path) -> None:
    columns = soak()
    columns["ax"][[10, 20, 30]] = np.nan  # single rows that are bridged
    columns = {name: np.delete(values, slice(100, 105)) for name, values in columns.items()}
    found = campaign_of_logs([save(tmp_path / "log.csv", columns)], LogOptions())
    assert [text.split(":")[1] for text in found.loaded.warnings if "a gap" in text] == ["102"]


def test_a_stamp_that_stood_still_is_no_gap(tmp_path: Path) -> None:
    columns = soak()
    columns["t"][500] = columns["t"][499]
    found = campaign_of_logs([save(tmp_path / "log.csv", columns)], LogOptions())
    assert any("1 rows have the time stamp of the row before" in note for note in found.notes)
    assert not any("a gap" in text for text in found.loaded.warnings)


def test_a_log_that_moves_and_rests_is_a_sequence(tmp_path: Path) -> None:
    columns = soak()
    rng = np.random.default_rng(5)
    for begin, axis in ((1000, "ax"), (2000, "ay"), (3000, "az")):
        for name in ("ax", "ay", "az"):
            columns[name][begin:] = (9.8 if name == axis else 0.0) + 1e-3 * rng.standard_normal(N - begin)
            columns[name][begin : begin + 50] += rng.standard_normal(50)
    found = campaign_of_logs([save(tmp_path / "log.csv", columns)], LogOptions())
    assert [step.kind for step in found.loaded.steps] == ["sequence"]


def test_several_logs_follow_one_another_by_their_clock_or_in_their_order(tmp_path: Path) -> None:
    first, second = soak(1), soak(2)
    one_clock = [save(tmp_path / "b.csv", second | {"t": second["t"] + 500}), save(tmp_path / "a.csv", first)]
    found = campaign_of_logs(one_clock, LogOptions())
    assert [soak.series.t[0] for soak in found.loaded.campaign.soaks] == pytest.approx([500, 0])
    again = [save(tmp_path / "c.csv", first), save(tmp_path / "d.csv", second)]
    found = campaign_of_logs(again, LogOptions(kinds=("dwell:1", "dwell:2")))
    assert [dwell.position for dwell in found.loaded.campaign.dwells] == [1, 2]
    assert [dwell.series.t[0] for dwell in found.loaded.campaign.dwells] == pytest.approx([0, N * PERIOD + 59.98])


@pytest.mark.parametrize("kind", ["turn:+x", "turn:+x:3"])
def test_the_revolutions_of_a_turn_are_counted_by_the_gyroscope(tmp_path: Path, kind: str) -> None:
    columns = soak()
    columns["gx"][500:3500] += 3 * 360 / (3000 * PERIOD)
    stated = LogOptions(ColumnOptions(unit_gyro="deg/s"), kinds=(kind,))
    found = campaign_of_logs([save(tmp_path / "turn.csv", columns)], stated)
    (turn,) = found.loaded.campaign.turns
    assert (turn.axis, turn.direction, turn.revolutions) == ("x", "+", 3)


@pytest.mark.parametrize(("axis", "sign"), [("x", 1), ("z", 1), ("y", -1)])
def test_a_rate_table_turned_the_gyroscope_that_follows_it_most(tmp_path: Path, axis: str, sign: int) -> None:
    rng, rate = np.random.default_rng(5), np.tile(np.linspace(-50, 50, 20), 3)
    gyro = {f"g{a}": 1e-3 * rate + 0.01 * rng.standard_normal(60) for a in "xyz"}  # all see a little of it
    gyro[f"g{axis}"] = 1.01 * sign * rate + 0.2
    log = save(tmp_path / "rates.csv", {"table": rate, **gyro})
    found = campaign_of_logs([log], LogOptions(ColumnOptions(reference="table")))
    (table,) = found.loaded.campaign.rate_tables
    assert table.axis == axis
    assert np.array_equal(table.reference, sign * rate)
    stated = LogOptions(ColumnOptions(reference="table"), kinds=("rate:x",))
    assert campaign_of_logs([log], stated).loaded.campaign.rate_tables[0].axis == "x"
    noise = save(tmp_path / "noise.csv", {"table": rate, "gz": rng.standard_normal(60)})
    with refused(DataRefused, None, "--as rate:z"):
        campaign_of_logs([noise], LogOptions(ColumnOptions(reference="table")))


@pytest.mark.parametrize("step", [1.0, 10.0, 5000.0])
def test_a_unit_of_time_that_the_steps_leave_open_is_asked_for(tmp_path: Path, step: float) -> None:
    columns = {"timestamp": step * np.arange(1000.0), "ax": 0.0}
    columns["ax"] = np.sin(columns["timestamp"])
    with pytest.raises(TimeUnitAsked) as asked:
        campaign_of_logs([save(tmp_path / "log.csv", columns)], LogOptions())
    offered = {unit: (rate, duration) for unit, rate, duration in asked.value.candidates}
    assert offered["ms"] == pytest.approx((1000 / step, 0.999 * step))
    stated = LogOptions(ColumnOptions(unit_time="ms"), kinds=("soak",))
    found = campaign_of_logs([tmp_path / "log.csv"], stated)
    assert found.loaded.tables.imu.sample_period_s == pytest.approx(step / 1000, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "scale", "offset"),
    [("temp", 1.0, 0.0), ("temp [K]", 1.0, 273.15), ("temp_degF", 1.8, 32.0), ("T_k", 1.0, 273.15),
     ("temperature", 1.0, 0.0), ("Temp(°C)", 1.0, 0.0), ("temp [0.1 degC]", 10.0, 0.0)],
)  # fmt: skip
def test_a_temperature_is_made_degc_by_its_name_or_its_size(
    tmp_path: Path, name: str, scale: float, offset: float
) -> None:
    columns = soak()
    true = columns.pop("temp")
    log = save(tmp_path / "log.csv", columns | {name: true * scale + offset})
    found = campaign_of_logs([log], LogOptions(ColumnOptions(temperature=name)))
    assert found.loaded.campaign.soaks[0].series.temperature == pytest.approx(true)


def test_wrapping_and_shared_stamps_become_times_with_the_right_mean_rate(tmp_path: Path) -> None:
    columns = soak()
    ticks = np.floor(columns["t"] * 1e3 / 100) * 100 % 65536 + 17  # ms, ten reads a second, 16 bits
    found = campaign_of_logs(
        [save(tmp_path / "log.csv", columns | {"t": ticks % 65536})], LogOptions(ColumnOptions(unit_time="ms"))
    )
    assert found.loaded.campaign.soaks[0].series.period == pytest.approx(PERIOD, rel=2e-3)
    assert any("65536" in note for note in found.notes)


def test_no_time_and_no_rate_time_that_goes_back_and_a_frozen_clock_are_refused(tmp_path: Path) -> None:
    columns = soak()
    del columns["t"]
    with refused(DataRefused, None, "--time", "--rate"):
        campaign_of_logs([save(tmp_path / "a.csv", columns)], LogOptions())
    back = np.concatenate((PERIOD * np.arange(2000), 7.123 + PERIOD * np.arange(2000)))
    with refused(DataRefused, ErrorCode.TIME_ORDER, "7.123", line=2002):
        campaign_of_logs([save(tmp_path / "b.csv", {"t": back, **columns})], LogOptions())
    with refused(DataRefused, ErrorCode.TIME_ORDER, line=3):
        campaign_of_logs([save(tmp_path / "d.csv", {"t": PERIOD * np.arange(N)[::-1], **columns})], LogOptions())
    with refused(DataRefused, ErrorCode.TIME_ORDER):
        campaign_of_logs([save(tmp_path / "c.csv", {"t": np.ones(N), **columns})], LogOptions())


def test_solve_refuses_a_campaign_without_a_site(tmp_path: Path) -> None:
    write_campaign(tmp_path / "c", campaign_of_logs([save(tmp_path / "log.csv", soak())], LogOptions()))
    with refused(DataRefused, None, "[site]"):
        read_for_solve([tmp_path / "c"])

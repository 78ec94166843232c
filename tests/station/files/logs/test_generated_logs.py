"""Time unit, sensors and units of generated logs: right, asked for or refused, never silently wrong."""

import re
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.cli import run
from station.errors import DataRefused, TimeUnitAsked
from station.files.logs.log_campaign import LogOptions, readings
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns
from station.files.logs.log_data import log_data
from station.files.logs.unit_checks import check_units
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, outputs_per_unit
from tests.station.files.logs.generated_logs import AXES, SENSORS, Channel, Log, generated_log

MAX_ASKED_TIME, MAX_ASKED_KIND = 0.15, 0.025
MAX_REFUSED = 0.005  # of logs that are right
KNOWN = {"gyro": GYRO_UNITS, "accel": ACCEL_UNITS}
ASKED = {ErrorCode.TIME_UNIT: "asked time", ErrorCode.COLUMNS: "asked kind"}
RIGHT = frozenset({"right", *ASKED.values(), "refused"})


def answer(log: Log, stated: ColumnOptions, asked: DataRefused) -> ColumnOptions | None:
    """Return what who knows the truth says to a question; None where the right answer is not offered."""
    if isinstance(asked, TimeUnitAsked):
        right = [unit for unit, hz, _ in asked.candidates if abs(hz / log.time.rate_hz - 1) < 0.1]
        return replace(stated, unit_time=right[0]) if right else None
    for sensor, text in re.findall(r"--(gyro|accel) ((?:[^,]+,){2}.+?)(?= or --|$)", str(asked)):
        names = tuple(text.split(","))
        if all(each in log.channels and log.channels[each].sensor == sensor for each in names):
            return replace(stated, gyro=names) if sensor == "gyro" else replace(stated, accel=names)
    return None


def outcome(log: Log) -> str:
    """Return what becomes of a log; questions are answered, and what follows is looked at as well."""
    stated, asked, table = ColumnOptions(), "", log.table
    while True:
        try:
            found = choose_columns(table, stated)
            data, _, _ = log_data(found, None, log.file)
            check_units(readings(found, data, LogOptions(stated)))
        except DataRefused as error:
            if error.code not in ASKED:
                return "refused"
            if (more := answer(log, stated, error)) is None or more == stated:
                return "asked without the right one"
            stated, asked = more, asked or ASKED[error.code]
        else:
            return wrongly(log, found) or asked or "right"


def wrongly(log: Log, found: LogColumns) -> str:
    """Return what is wrong of the time, the sensor kinds and the units that are claimed; nothing where right."""
    step = np.diff(found.unit_time.linear(log.time.stamps) * found.unit_time.seconds)
    duration = float(np.sum(step) + 86400.0 * np.sum(step < -43200.0))  # a clock begins again at midnight
    if found.time != log.time.name or abs(duration / np.ptp(log.time.t) - 1) > 1e-2:
        return "wrong time"
    for sensor, names, unit in (
        ("gyro", found.gyro, found.unit_gyro),
        ("accel", found.accel, found.unit_accel),
    ):
        if wrong := wrong_sensor(log, sensor, [log.channels.get(name or "") for name in names], unit):
            return wrong
        if any(name and name not in log.channels for name in names):
            return f"another column for {sensor}"
    return ""


def wrong_sensor(log: Log, sensor: str, chosen: list[Channel | None], unit: str | None) -> str:
    """Return what is wrong of the columns that were ``chosen`` as x, y, z of a sensor, and of their unit."""
    if not any(chosen):
        return f"missed {sensor}" if any(each.sensor == sensor for each in log.channels.values()) else ""
    if [(each.sensor, each.axis) for each in chosen if each] != [(sensor, axis) for axis in AXES]:
        return f"wrong columns for {sensor}"
    first = next(each for each in chosen if each)
    claimed = outputs_per_unit(unit, KNOWN[sensor]) if unit else None
    if claimed is None:
        return f"unit of {sensor} not read" if first.is_stated else ""
    return "" if abs(claimed / first.per_unit - 1) < 1e-3 else f"wrong unit of {sensor}"


@pytest.mark.parametrize(("seed", "number"), [(49, 250), pytest.param(50, 2000, marks=pytest.mark.proof)])
def test_no_time_unit_kind_of_sensor_or_unit_is_silently_wrong(seed: int, number: int) -> None:
    rng = np.random.default_rng(seed)
    logs = [generated_log(rng) for _ in range(number)]
    found = [outcome(log) for log in logs]
    shown = [
        (each, log.kind, log.time, list(log.columns))
        for log, each in zip(logs, found, strict=True)
        if each not in RIGHT
    ]
    assert shown == []
    count = Counter(found)
    assert count["asked time"] <= MAX_ASKED_TIME * number
    assert count["asked kind"] <= MAX_ASKED_KIND * number
    assert count["refused"] <= MAX_REFUSED * number


@pytest.mark.parametrize("number", [8, pytest.param(60, marks=pytest.mark.proof)])
def test_files_are_read_by_the_program_as_they_are(
    number: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `station diagnose` writes of each file has the time, columns and units of the truth, or it asked."""
    rng, count = np.random.default_rng(7), Counter[str]()
    for i in range(number):
        log = generated_log(rng, f"{i}.csv")
        while len(log.time.t) > 300:  # the diagnosis that follows is quick
            log = generated_log(rng, f"{i}.csv")
        code = run(["diagnose", str(log.write(tmp_path)), "--as", "soak", "--campaign", str(tmp_path / str(i))])
        reported = capsys.readouterr().err
        expected = outcome(log)
        if code in {2, 3} and not (tmp_path / str(i)).exists():
            assert expected.startswith("asked"), (reported, log.time, list(log.columns))
            assert re.search(r"--unit-time|--accel|--gyro", reported)
        else:
            assert code in {0, 5}
            assert expected == "right"
            check_folder(tmp_path / str(i), log)
        count[expected] += 1
    assert count["right"] > 0.7 * number


def check_folder(folder: Path, log: Log) -> None:
    """Compare a campaign's folder with the truth of the log that it was made of."""
    with (folder / "campaign.toml").open("rb") as file:
        imu = tomllib.load(file)["imu"]
    assert imu["sample_period_s"] * log.time.rate_hz == pytest.approx(1, rel=0.02)
    table = np.genfromtxt(folder / log.file, delimiter=",", names=True)
    if "interpolated" in (table.dtype.names or ()):
        table = table[table["interpolated"] == 0]
    for sensor in SENSORS:
        letter = sensor[0]
        channels = [(name, each) for name, each in log.channels.items() if each.sensor == sensor]
        assert bool(channels) == (f"{letter}x" in (table.dtype.names or ()))
        unit = imu.get(f"unit_{sensor}")
        claimed = outputs_per_unit(unit, KNOWN[sensor]) if unit else None
        for axis in AXES if channels else "":
            alike = [
                each for name, each in channels
                if each.axis == axis and np.allclose(log.columns[name][: len(table)], table[f"{letter}{axis}"])
            ]  # fmt: skip
            assert alike
            assert claimed is None or claimed == pytest.approx(alike[0].per_unit, rel=1e-3)

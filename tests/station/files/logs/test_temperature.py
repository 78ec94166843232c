"""Temperatures of logs: sentinels are empty cells, a unit that size leaves open is asked for."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from station.applying.log_source import LogSource
from station.errors import DataRefused
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.logs.log_data import log_data
from station.files.output_units import stated_temperature_unit, temperature_unit
from station.files.tables.reader import read_table
from tests.refusals import refused

N = 4000  # more than the rows that a streamed log is opened with


def written(file: Path, name: str, values: FloatArray) -> Path:
    rng = np.random.default_rng(1)
    rows = np.column_stack((np.arange(N) / 50, rng.normal(0, 0.01, (N, 3)), values))
    np.savetxt(file, rows, delimiter=",", header=f"t_s,gx_dps,gy_dps,gz_dps,{name}", comments="", fmt="%.6f")
    return file


def read(file: Path, stated: ColumnOptions) -> tuple[FloatArray | None, list[str]]:
    """Return the temperature [degC] (n,) of a log, None where it is not used, and what was guessed of it.

    A log that is streamed is read in the same way.
    """
    found = choose_columns(read_table(file), stated)
    whole = log_data(found, None, "log.csv")[0].columns.get("temp_c")
    streamed = LogSource.open(file, stated)
    parts = [block.temperature for block in streamed.blocks()]
    of_temperature = [guess for guess in found.guesses if "emp" in guess and not guess.startswith("not used")]
    assert of_temperature == [guess for guess in streamed.found.guesses if guess in of_temperature]
    if whole is None:
        assert parts[0] is None
        return None, of_temperature
    np.testing.assert_array_equal(np.concatenate([part for part in parts if part is not None]), whole)
    return whole, of_temperature


def warming() -> FloatArray:
    return np.linspace(20.0, 31.0, N)


@pytest.mark.parametrize("sentinel", [-999.0, 9999.0, -273.15, 32767.0, -1e30])
@pytest.mark.parametrize(("name", "zero"), [("temp", 0.0), ("temp_c", 0.0), ("temp [K]", 273.15)])
@pytest.mark.parametrize("stated", [True, False])
def test_cells_beyond_any_temperature_are_empty_and_counted(
    tmp_path: Path, sentinel: float, name: str, zero: float, stated: bool
) -> None:
    cells = np.random.default_rng(2).choice(N, 60, replace=False)
    values = warming() + zero
    values[cells] = sentinel
    file = written(tmp_path / "log.csv", name, values)
    found, guesses = read(file, ColumnOptions(temperature=name if stated else None))
    expected = warming()
    expected[cells] = np.nan
    assert found == pytest.approx(expected, abs=1e-5, nan_ok=True)
    (counted,) = [guess for guess in guesses if "empty" in guess]
    assert f"60 of {N}" in counted
    assert f"{sentinel:.6g}" in counted


@pytest.mark.parametrize(
    ("unit", "zero", "step"),
    [("K", -273.15, 1.0), ("0.1degC", 0.0, 0.1), ("0.01 K", -273.15, 0.01), ("degF", -32 / 1.8, 1 / 1.8),
     ("0.0125degC+25", 25.0, 0.0125), ("1e-3degC", 0.0, 1e-3), ("0.5degF+100", 68 / 1.8, 0.5 / 1.8)],
)  # fmt: skip
def test_a_unit_that_is_stated_wins_over_name_and_size(
    tmp_path: Path, unit: str, zero: float, step: float
) -> None:
    file = written(tmp_path / "log.csv", "temp_c", (warming() - zero) / step)
    found, _ = read(file, ColumnOptions(unit_temperature=unit))
    assert found == pytest.approx(warming(), abs=1e-4)


@pytest.mark.parametrize(
    ("values", "offered"),
    [(warming() + 273.15, ("K", "0.1degC")), (np.rint(10 * warming() + 50), ("K", "0.1degC")),
     (np.rint(100 * warming()), ("0.01degC",)), (np.linspace(-3900.0, -1900.0, N), ("counts",)),
     (np.linspace(-360.0, 30.0, N), ("counts",)), (np.linspace(0.0, 390.0, N), ("counts",))],
    ids=["kelvins", "tenths", "hundredths", "counts", "counts that cross", "counts from zero"],
)  # fmt: skip
@pytest.mark.parametrize("has_sentinels", [False, True])
def test_a_size_that_several_units_explain_is_asked_about(
    tmp_path: Path, values: FloatArray, offered: tuple[str, ...], has_sentinels: bool
) -> None:
    values = np.where(has_sentinels & (np.arange(N) % 30 == 7), -999.0, values)
    file = written(tmp_path / "log.csv", "TEMP_OUT", values)
    found, guesses = read(file, ColumnOptions())
    assert found is None
    assert all(each in guesses[0] for each in (*offered, "--unit-temperature"))
    with refused(DataRefused, None, "--unit-temperature"):
        choose_columns(read_table(file), ColumnOptions(temperature="TEMP_OUT"))


def test_a_column_of_which_most_cells_are_impossible_or_text_is_not_used(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "temp_c", 1000 + warming())
    found, guesses = read(file, ColumnOptions())
    assert found is None
    assert "--unit-temperature" in guesses[0]
    file.write_text(file.read_text().replace(",1020.000000\n", ",cold\n", 1))
    assert read(file, ColumnOptions())[0] is None


def test_a_command_that_needs_no_temperature_does_not_speak_of_one(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "temp", np.full(N, -999.0))
    found = choose_columns(read_table(file), ColumnOptions(temperature=""))
    assert found.temperature is None
    assert [guess for guess in found.guesses if "temp" in guess] == ["not used: temp"]


@pytest.mark.parametrize(
    ("text", "name"),
    [("Degrees Celsius", "degC"), ("deg C", "degC"), ("°C", "degC"), ("C", "degC"), ("K", "K"), ("Kelvin", "K"),
     ("°F", "degF"), ("degrees_fahrenheit", "degF"), ("0.10 degC", "0.1degC"), ("0.0125degC+25", "0.0125degC+25")],
)  # fmt: skip
def test_units_of_temperature_as_people_write_them(text: str, name: str) -> None:
    found = temperature_unit(text)
    assert found is not None
    assert found.name == name


@pytest.mark.parametrize("text", ["", "deg", "16k", "0degC", "0.1", "0.0degC", "degC+", "5K", "x8005"])
def test_what_is_no_unit_of_temperature(text: str) -> None:
    assert temperature_unit(text) is None
    with pytest.raises(ValueError, match="found unit"):
        stated_temperature_unit(text)

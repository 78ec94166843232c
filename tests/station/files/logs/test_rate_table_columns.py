"""Columns of a rate table: its time, where a name says so, and its reference, where nothing else is possible."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.logs.inferred_reference import inferred_reference
from station.files.logs.log_campaign import LogOptions, campaign_of_logs
from station.files.logs.log_columns import ColumnOptions
from station.files.tables.reader import read_table
from tests.refusals import refused

RATES = np.tile([0.0, 5.0, -5.0, 10.0, -10.0, 50.0, -50.0, 100.0, -100.0, 20.0], 2)
OUTPUT = 1.0003 * RATES + 0.002 + 1e-4 * np.random.default_rng(0).standard_normal(len(RATES))
STEP_S = 120.0
T = STEP_S * np.arange(len(RATES))


def written(folder: Path, header: str, *columns: Sequence[float] | np.ndarray) -> Path:
    file = folder / "table.csv"
    rows = "\n".join(",".join(f"{each:.6f}" for each in row) for row in zip(*columns, strict=True))
    file.write_text(f"{header}\n{rows}\n")
    return file


@pytest.mark.parametrize(("name", "per_second"), [("t_s", 1.0), ("time [min]", 1 / 60), ("time_s", 1.0)])
def test_a_time_that_its_name_states_is_taken_in_the_unit_that_it_states(
    name: str, per_second: float, tmp_path: Path
) -> None:
    file = written(tmp_path, f"{name},rate_ref_deg_s,gz_deg_s", T * per_second, RATES, OUTPUT)
    stated = ColumnOptions(reference="rate_ref_deg_s")
    for columns in (ColumnOptions(), stated, ColumnOptions(reference="rate_ref_deg_s", time=name)):
        (table,) = campaign_of_logs([file], LogOptions(columns)).loaded.campaign.rate_tables
        assert table.t is not None
        np.testing.assert_allclose(np.diff(table.t), STEP_S, atol=1e-2)


@pytest.mark.parametrize(("name", "t"), [("t_s", T[::-1]), ("t", T)])
def test_a_time_that_does_not_rise_or_has_no_unit_is_not_taken(name: str, t: np.ndarray, tmp_path: Path) -> None:
    file = written(tmp_path, f"{name},rate_ref_deg_s,gz_deg_s", t, RATES, OUTPUT)
    (table,) = campaign_of_logs([file], LogOptions(ColumnOptions(reference="2"))).loaded.campaign.rate_tables
    assert table.t is None


@pytest.mark.parametrize("header", ["rate_ref_deg_s,gz_deg_s", "gyro_z_dps,table_rate_dps"])
def test_a_reference_that_is_the_only_one_possible_is_inferred(header: str, tmp_path: Path) -> None:
    columns = (RATES, OUTPUT) if header.startswith("rate") else (OUTPUT, RATES)
    found = campaign_of_logs([written(tmp_path, header, *columns)], LogOptions())
    (table,) = found.loaded.campaign.rate_tables
    np.testing.assert_allclose(table.reference, RATES)
    assert table.lines == list(range(2, len(RATES) + 2))
    assert any("rate table, reference is" in each for each in found.guesses)


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("rate_ref_deg_s,rate_cmd_deg_s,gz_deg_s", (RATES, RATES, OUTPUT)),  # which of two
        ("rate_ref_deg_s,gz_deg_s", (RATES, OUTPUT[::-1] ** 2)),  # no output follows
        ("t_s,rate_ref_deg_s,gz_deg_s", (T / 1e4, RATES, OUTPUT)),  # samples of a log
        ("enc_deg,gz_deg_s", (RATES, OUTPUT)),  # an angle
    ],
)
def test_a_reference_of_which_two_readings_are_possible_is_not_inferred(
    header: str, columns: tuple[np.ndarray, ...], tmp_path: Path
) -> None:
    assert inferred_reference(read_table(written(tmp_path, header, *columns)), ColumnOptions()) is None


def test_what_is_not_inferred_is_asked_for(tmp_path: Path) -> None:
    file = written(tmp_path, "rate_ref_deg_s,rate_cmd_deg_s,gz_deg_s", RATES, RATES, OUTPUT)
    with refused(DataRefused, ErrorCode.COLUMNS, "--reference"):
        campaign_of_logs([file], LogOptions())

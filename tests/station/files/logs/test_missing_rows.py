"""Rows of a log without a sample: a few in sequence leave the recording whole, and make no noise of their own."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.missing_rows import INTERPOLATED, rows_lost
from procedures.counts.sentinels import sentinel_cells
from procedures.errors import ErrorCode
from procedures.samples.channel_noise import ChannelNoise, channel_noise
from station.errors import DataRefused
from station.files.logs.log_campaign import LogCampaign, LogOptions, campaign_of_logs, write_campaign
from station.files.logs.log_columns import ColumnOptions
from tests.refusals import refused

N, PERIOD, SIGMA = 40_000, 0.01, 0.02
STATED = LogOptions(ColumnOptions(unit_gyro="deg/s", unit_accel="g"))


def soak() -> dict[str, FloatArray]:
    values = SIGMA * np.random.default_rng(5).standard_normal((6, N))
    values[5] += 1.0
    return {"t": PERIOD * np.arange(N), **dict(zip(("gx", "gy", "gz", "ax", "ay", "az"), values, strict=True))}


def save(file: Path, columns: dict[str, FloatArray]) -> Path:
    cells = (
        ["" if value != value else f"{value:.6f}" for value in values.tolist()] for values in columns.values()
    )
    file.write_text("\n".join([",".join(columns), *map(",".join, zip(*cells, strict=True))]) + "\n")
    return file


def lone_rows(share: float) -> BoolArray:
    """Mark a share of the rows, at random, no more than three in sequence."""
    mask = np.random.default_rng(6).random(N) < share
    mask[:2] = mask[-2:] = False
    for i in np.flatnonzero(mask).tolist():
        mask[i] = not mask[i - 3 : i].all()
    return mask


def read(folder: Path, columns: dict[str, FloatArray]) -> LogCampaign:
    return campaign_of_logs([save(folder / "log.csv", columns)], STATED)


def noise(found: LogCampaign) -> list[ChannelNoise]:
    return channel_noise([found.loaded.campaign], {"gyroscope": np.ones(3), "accelerometer": np.ones(3)})


@pytest.mark.parametrize("share", [0.001, 0.025, 0.1])
@pytest.mark.parametrize("kind", ["empty", "lost", "9999"])
def test_the_random_walk_is_that_of_the_rows_that_were_measured(share: float, kind: str, tmp_path: Path) -> None:
    columns, mask = soak(), lone_rows(share)
    if kind == "lost":
        columns = {name: values[~mask] for name, values in columns.items()}
    else:
        columns["gy"][mask] = 9999.0 if kind == "9999" else np.nan
    found = read(tmp_path, columns)
    assert not [text for text in found.loaded.warnings if "a gap" in text]
    truth = SIGMA * np.sqrt(PERIOD)
    for each in noise(found):
        walk = each.fit.terms["random_walk"]
        assert each.seconds == pytest.approx(N * PERIOD)
        assert walk.value is not None
        assert (walk.high - walk.low) / truth < 0.05  # of the whole recording; a hundred rows know it by 15 %
        assert abs(walk.value - truth) < 2 * (walk.high - walk.low) / 2
        values = [one.values["rows"] for one in each.conditions if one.name == "interpolated_rows"]
        assert values == [mask.sum()]


def test_a_line_keeps_its_frequency_over_missing_rows(tmp_path: Path) -> None:
    columns = soak()
    columns["gx"] += SIGMA * np.sin(2 * np.pi * 7.3 * columns["t"])
    columns["gx"][lone_rows(0.05)] = np.nan
    (found,) = (one for one in noise(read(tmp_path, columns)) if (one.triad, one.axis) == ("gyroscope", "x"))
    assert [line.hertz for line in found.lines] == pytest.approx([7.3], abs=1e-3)


def test_a_longer_gap_splits_a_recording_and_so_do_many(tmp_path: Path) -> None:
    columns = soak()
    columns["gx"][10_000:10_020] = np.nan
    assert [each.seconds for each in noise(read(tmp_path, columns))] == pytest.approx([299.8] * 6)
    columns = soak()
    columns = {name: values[~lone_rows(0.4)] for name, values in columns.items()}
    found = read(tmp_path, columns)
    assert INTERPOLATED not in found.data["log.csv"].columns
    assert "missing" in found.notes[0]


def test_a_late_stamp_is_no_lost_row() -> None:
    t = PERIOD * np.arange(1000)
    t[500:503] = t[502] + np.arange(3) * 1e-4
    assert not rows_lost(t).any()
    assert rows_lost(np.delete(t, [200, 201])).sum() == 2


def test_each_triad_is_used_at_its_own_rate(tmp_path: Path) -> None:
    columns = soak()
    for name in ("ax", "ay", "az"):
        columns[name][np.arange(N) % 4 != 0] = np.nan
    found = read(tmp_path, columns)
    series = found.loaded.campaign.soaks[0].series
    assert len(series) == pytest.approx(N, abs=4)
    assert series.accel is not None
    assert np.allclose(series.accel[2:1000:4], (series.accel[:999:4] + series.accel[4:1001:4])[:250] / 2)
    for each in noise(found):
        period = PERIOD * (4 if each.triad == "accelerometer" else 1)
        walk = each.fit.terms["random_walk"]
        assert walk.low <= SIGMA * np.sqrt(period) * 1.02
        assert walk.high >= SIGMA * np.sqrt(period) * 0.98


def test_rows_of_one_triad_in_no_order_are_refused_with_the_option(tmp_path: Path) -> None:
    columns, rows = soak(), np.random.default_rng(1).random(N) < 0.5
    for name in ("ax", "ay", "az"):
        columns[name][rows] = np.nan
    for name in ("gx", "gy", "gz"):
        columns[name][~rows] = np.nan
    with refused(DataRefused, ErrorCode.COLUMNS, "--accel -,-,-", "--gyro -,-,-"):
        read(tmp_path, columns)


def test_the_marks_are_kept_in_a_campaign_and_no_noise_is_made_of_them(tmp_path: Path) -> None:
    from station.files.campaign_folder.campaign_reading import read_campaign

    columns = soak()
    columns["az"][lone_rows(0.02)] = np.nan
    found = read(tmp_path, columns)
    write_campaign(tmp_path / "c", found)
    series = read_campaign(tmp_path / "c").campaign.soaks[0].series
    assert np.array_equal(series.extra[INTERPOLATED], found.loaded.campaign.soaks[0].series.extra[INTERPOLATED])


def test_only_what_lies_far_from_all_others_and_does_not_stay_is_a_sentinel() -> None:
    draw = np.random.default_rng(3)
    values = draw.standard_normal((5000, 2))
    values[::40, 0] = -999.0
    assert np.array_equal(np.flatnonzero(sentinel_cells(values)[:, 0]), np.arange(0, 5000, 40))
    assert not sentinel_cells(values)[:, 1].any()
    moving = np.clip(300 * np.sin(np.arange(5000) / 100)[:, None], -250, 250)
    assert not sentinel_cells(moving).any()  # the end of its range
    stays = draw.standard_normal((5000, 1))
    stays[1000:2000] = 100.0
    assert not sentinel_cells(stays).any()


def test_one_number_in_all_channels_is_no_chance_unless_the_channels_are_coarse() -> None:
    draw = np.random.default_rng(4)
    counts = np.rint(draw.normal(0, 9000, (2000, 6)))
    counts[500] = counts[900] = 9999.0
    assert np.array_equal(np.flatnonzero(sentinel_cells(counts).all(axis=1)), [500, 900])
    coarse = draw.integers(0, 4, (2000, 6)).astype(float)
    assert not sentinel_cells(coarse).any()


@pytest.mark.parametrize(("options", "expected"), [
    ({"rate_hz": 50.0}, ["100", "50"]), ({"rate_hz": 50.0, "time": "t"}, ["100", "50"]), ({"rate_hz": 100.0}, []),
])  # fmt: skip
def test_a_rate_that_a_time_column_contradicts_is_reported(
    options: dict[str, Any], expected: list[str], tmp_path: Path
) -> None:
    columns = soak()
    file = save(tmp_path / "log.csv", {"t [s]": columns.pop("t"), **columns})
    options |= {"time": "t [s]"} if "time" in options else {}
    found = campaign_of_logs([file], LogOptions(ColumnOptions(unit_gyro="deg/s", unit_accel="g", **options)))
    notes = [note for note in found.notes if "--rate" in note]
    assert len(notes) == bool(expected)
    assert all(f"{hertz} Hz" in notes[0] or f"--rate {hertz} " in notes[0] for hertz in expected)


def test_a_counter_is_a_time_at_the_rate_that_was_stated(tmp_path: Path) -> None:
    columns = soak()
    file = save(tmp_path / "log.csv", {"PacketCounter": np.arange(N) % 65536.0, **columns})
    stated = ColumnOptions(unit_gyro="deg/s", unit_accel="g", time="PacketCounter", rate_hz=100.0)
    assert campaign_of_logs([file], LogOptions(stated)).loaded.campaign.soaks[0].series.period == pytest.approx(
        0.01
    )

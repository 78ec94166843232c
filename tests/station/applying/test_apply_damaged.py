"""Damaged archives and tables: applied as far as nothing shows, or refused in one line, and nothing is written."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import explain
from tests.station.applying.inputs import COLUMNS, K_A, NAMES, PERIOD, calibration_file, write_csv, write_mcap
from tests.station.applying.run import apply, refusal, written

SHORT = {name: column[:400] for name, column in COLUMNS.items()}
DAMAGES = 12


def write(path: Path) -> Path:
    match path.name:
        case "stored.npz":
            np.savez(path, **SHORT)
        case "packed.npz":
            np.savez_compressed(path, both=np.column_stack(list(SHORT.values())[1:7]).T.copy(), **SHORT)
        case "gyro.npy":
            np.save(path, np.column_stack(list(SHORT.values())))
        case _:
            import pyarrow
            import pyarrow.parquet as parquet

            parquet.write_table(pyarrow.table(SHORT), path, row_group_size=77)
    return path


@pytest.mark.parametrize("name", ["stored.npz", "packed.npz", "gyro.npy", "a.parquet"])
def test_damage_is_refused_in_one_line_and_nothing_is_written(name: str, tmp_path: Path) -> None:
    known, source, out = calibration_file(tmp_path), write(tmp_path / name), tmp_path / "out.csv"
    whole, draw = source.read_bytes(), np.random.default_rng(7)
    decisive = [*range(0, 8, 3), *range(len(whole) - 60, len(whole), 9)]  # magic, directory and footer
    for i, at in enumerate([*decisive, *draw.integers(0, len(whole), DAMAGES).tolist()]):
        content = bytearray(whole[: at if i % 5 == 4 else None])
        if at < len(content):
            content[at] ^= 1 << int(draw.integers(8))
        source.write_bytes(content)
        asked = ("--time", "1", "--gyro", "2,3,4", "--accel", "5,6,7") if name == "gyro.npy" else ()
        result = apply(source, "--calibration", known, "--out", out, *asked)
        code, line = explain(result.exception) if result.exception else (result.exit_code, "")
        assert code in {0, 3}, (i, at, line)
        assert "\n" not in line
        assert code == 0 or not out.exists()
        out.unlink(missing_ok=True)


@pytest.mark.parametrize("tail", [b"", bytes(300)], ids=["cut", "zeros"])
def test_a_recording_that_was_cut_short_is_applied_so_far_and_says_so(tail: bytes, tmp_path: Path) -> None:
    whole = write_mcap(tmp_path / "whole.mcap").read_bytes()
    cut, out = tmp_path / "cut.mcap", tmp_path / "out.csv"
    cut.write_bytes(whole[: int(0.95 * len(whole))] + tail)
    result = apply(cut, "--calibration", calibration_file(tmp_path), "--out", out)
    assert result.exit_code == 0, result.exception
    assert "the recording was cut short" in result.output
    assert "the recording was cut short" in json.loads((tmp_path / "out.csv.json").read_text())["warnings"][0]


def test_rows_of_one_sentinel_are_no_samples(tmp_path: Path) -> None:
    rows = np.arange(50, 400, 100)
    spoiled = {name: np.where(np.isin(np.arange(400), rows), 9999.0, SHORT[name]) for name in NAMES}
    without = {name: np.delete(column, rows) for name, column in SHORT.items()}
    outs = list[Path]()
    for name, columns in (("spoiled", SHORT | spoiled), ("without", without)):
        outs.append(tmp_path / f"{name}.npz")
        source = write_csv(tmp_path / f"{name}.csv", columns)
        result = apply(source, "--calibration", calibration_file(tmp_path), "--out", outs[-1])
        assert result.exit_code == 0, result.exception
        assert ("9999" in result.output) == (name == "spoiled")
    assert np.allclose(*map(written, outs), rtol=1e-12, atol=1e-12)


def test_rows_of_one_triad_are_not_lost_in_silence(tmp_path: Path) -> None:
    slow = {name: np.where(np.arange(400) % 4 == 0, SHORT[name], np.nan) for name in ("ax", "ay", "az")}
    source, out = tmp_path / "slow.npz", tmp_path / "out.npz"
    np.savez(source, **SHORT | slow)
    asked = source, "--calibration", calibration_file(tmp_path), "--out", out
    found = refusal(apply(*asked))
    assert found.code is ErrorCode.COLUMNS
    assert "--accel -,-,-" in str(found)
    result = apply(*asked, "--accel", "-,-,-")
    assert result.exit_code == 0, result.exception
    assert len(written(out)) == 400


LONG = 98_304  # rows: several blocks


def long_log() -> dict[str, np.ndarray]:
    counts = np.rint(np.random.default_rng(3).normal((0, 0, 0, 0, 0, K_A[2] * PERIOD), 50, (LONG, 6)))
    return {"t_s": 0.02 * np.arange(1, LONG + 1), **dict(zip(NAMES, counts.T, strict=True))}


def test_a_sentinel_of_the_whole_log_is_none_of_a_block(tmp_path: Path) -> None:
    columns, rows, out = long_log(), [1000, 40_000, 80_000], tmp_path / "out.npz"
    columns["gy"][rows] = 99_999.0
    np.savez(tmp_path / "log.npz", **columns)
    result = apply(tmp_path / "log.npz", "--calibration", calibration_file(tmp_path), "--out", out)
    assert result.exit_code == 0, result.exception
    assert len(written(out)) == LONG - len(rows)
    assert "3 rows with 99999" in result.output


@pytest.mark.parametrize(("begin", "is_refused"), [(LONG // 6, False), (LONG // 3, True)])
def test_a_triad_may_begin_late(begin: int, is_refused: bool, tmp_path: Path) -> None:
    columns, out = long_log(), tmp_path / "out.npz"
    for name in NAMES[:3]:
        columns[name][:begin] = np.nan
    np.savez(tmp_path / "log.npz", **columns)
    result = apply(tmp_path / "log.npz", "--calibration", calibration_file(tmp_path), "--out", out)
    if is_refused:
        assert refusal(result).code is ErrorCode.COLUMNS
        assert not out.exists()
    else:
        assert result.exit_code == 0, result.exception
        assert len(written(out)) == LONG - begin
        assert np.isfinite(written(out)).all()


@pytest.mark.parametrize("accel", [(), ("--accel", "-,-,-")])
def test_interpolated_rows_of_a_used_triad_are_not_written(accel: tuple[str, ...], tmp_path: Path) -> None:
    marks, out = np.zeros(400), tmp_path / "out.npz"
    marks[[50, 51, 200, 300]] = 3, 1, 2, 2
    source = write_csv(tmp_path / "step.csv", SHORT | {"interpolated": marks})
    result = apply(source, "--calibration", calibration_file(tmp_path), "--out", out, *accel)
    assert result.exit_code == 0, result.exception
    lost = 2 if accel else 4
    assert len(written(out)) == 400 - lost
    assert f"{lost} rows without a measured number" in result.output

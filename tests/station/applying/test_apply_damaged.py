"""Damaged archives and tables: applied as far as nothing shows, or refused in one line, and nothing is written."""

import json
from pathlib import Path

import numpy as np
import pytest

from station.errors import explain
from tests.station.applying.inputs import COLUMNS, calibration_file, write_mcap
from tests.station.applying.run import apply

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

"""The short form of tests/benchmarks/hostile_frames.py, and that its control row does see wrong frames."""

import subprocess
import sys

from drivers.wire import FORMATS
from tests.paths import ROOT


def test_damaged_frames_neither_crash_a_decoder_nor_become_data() -> None:
    command = [sys.executable, "-m", "tests.benchmarks.hostile_frames", "--frames", "10000", "--seed", "7"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    header, *lines = done.stdout.splitlines()
    rows = [dict(zip(header.split(), line.split(), strict=True)) for line in lines]
    assert [row["format"] for row in rows] == [*FORMATS, "rawimusx-cut-to-8-bits"]
    assert {row["crashes"] for row in rows} == {"0"}
    strong = {name for name, wire in FORMATS.items() if wire.check_bits >= 32}
    assert {row["wrong"] for row in rows if row["format"] in strong} == {"0"}
    assert all(int(row["wrong"]) <= float(row["expected"]) for row in rows[:-1] if row["format"] not in strong)
    assert int(rows[-1]["wrong"]) > 0

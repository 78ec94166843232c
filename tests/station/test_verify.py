"""``SHA256SUMS``: written as sha256sum does, and what differs from it is named."""

import hashlib
import shutil
import subprocess
from pathlib import Path

import pytest

from procedures.errors import ErrorCode
from station import cli
from station.errors import CannotWrite
from station.files.sha256sums import append_hash
from tests.refusals import refused


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    for name in ("dwell_01.mcap", "turn x.mcap", "note.txt"):
        (tmp_path / name).write_bytes(name.encode() * 1000)
        append_hash(tmp_path, name, hashlib.sha256(name.encode() * 1000).hexdigest())
    return tmp_path


def test_an_untouched_folder_verifies(recorded: Path) -> None:
    assert cli.run(["verify", str(recorded)]) == 0


def test_sha256sum_agrees(recorded: Path) -> None:
    if shutil.which("sha256sum") is None:
        pytest.skip("no sha256sum here")
    subprocess.run(
        ["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=recorded, check=True, capture_output=True
    )


@pytest.mark.parametrize("change", ["bit", "gone", "longer"])
def test_the_first_altered_file_is_named(recorded: Path, change: str, capsys: pytest.CaptureFixture[str]) -> None:
    file = recorded / "turn x.mcap"
    content = bytearray(file.read_bytes())
    if change == "bit":
        content[77] ^= 4
    file.write_bytes(content + b"x" * (change == "longer"))
    if change == "gone":
        file.unlink()
    assert cli.run(["verify", str(recorded)]) == 1
    error = capsys.readouterr().err
    assert "turn x.mcap: found" in error
    assert error.count("\n") == 1


def test_a_full_disk_leaves_no_half_line(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    before = (recorded / "SHA256SUMS").read_bytes()
    monkeypatch.setattr("os.fsync", full)
    with refused(CannotWrite, ErrorCode.DISK_FULL):
        append_hash(recorded, "next.mcap", "0" * 64)
    assert (recorded / "SHA256SUMS").read_bytes() == before


def test_a_step_that_was_slipped_in_is_named(recorded: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = b"""format = "campaign/1"
[imu]
model = "a"
serial = "b"
sample_period_s = 1
output = "rate"
[site]
latitude_deg = 0
[[sequence]]
file = "other.csv"
"""
    (recorded / "campaign.toml").write_bytes(content)
    append_hash(recorded, "campaign.toml", hashlib.sha256(content).hexdigest())
    assert cli.run(["verify", str(recorded)]) == 1
    assert "other.csv" in capsys.readouterr().err

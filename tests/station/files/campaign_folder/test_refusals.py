"""Each way to break a folder: exit 3, nothing written, and one line that names the file and its line."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from station import cli

Breaking = Callable[[Path], object]


def _edit(name: str, old: str, new: str) -> Breaking:
    def breaking(folder: Path) -> None:
        text = (folder / name).read_bytes()
        assert old.encode() in text
        (folder / name).write_bytes(text.replace(old.encode(), new.encode(), 1))

    return breaking


def _csv(old: str, new: str) -> Breaking:
    return _edit("one.csv", old, new)


def _toml(old: str, new: str) -> Breaking:
    return _edit("campaign.toml", old, new)


def _replace(name: str, make: Breaking) -> Breaking:
    def breaking(folder: Path) -> None:
        (folder / name).unlink()
        make(folder / name)

    return breaking


def _sparse(path: Path) -> None:
    with path.open("wb") as stream:
        stream.truncate(4 * 2**30 + 1)


def _link_outside(path: Path) -> None:
    outside = path.parent.parent / "outside.csv"
    outside.write_text("t_s,gx,gy,gz\n1,1,1,1\n")
    path.symlink_to(outside)


CELL = "1.02,1,2,-3,4,0,-6,23.5"
MEASURED = (
    '[fixture.measured]\nnames = ["parallelism.x.y", "skew.x.y"]\nvalue_rad = [1e-5, 2e-5]\n'
    "covariance_rad2 = [[1e-12, 0.0], [0.0, 1e-12]]\n"
)
REFUSED = {
    "no data file": (_replace("one.csv", lambda p: None), "campaign.toml:14:"),
    "no campaign.toml": (_replace("campaign.toml", lambda p: None), "campaign.toml"),
    "wrong header": (_csv("t_s,gx", "time,gx"), "one.csv:1:"),
    "unknown column": (_csv("temp_c", "temperature"), "one.csv:1:"),
    "column twice": (_csv("temp_c", "gx"), "one.csv:1:"),
    "no time": (_csv("t_s,gx", "gx"), "one.csv:1:"),
    "part of a triad": (_csv("gx,gy,gz", "gx,gy,aux_a"), "one.csv:1:"),
    "byte order mark": (_csv("t_s", "\ufefft_s"), "one.csv:1:"),
    "text in a number": (_csv(CELL, "1.02,1,2,-3x,4,0,-6,23.5"), "one.csv:3:"),
    "real count": (_csv(CELL, "1.02,1.5,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "nan": (_csv(CELL, "nan,1,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "blank": (_csv(CELL, "1.02, 1,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "empty count": (_csv(CELL, "1.02,,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "decimal comma": (_csv(CELL, "1,02,1,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "cell missing": (_csv(CELL, "1.02,1,2,-3,4,0,-6"), "one.csv:3:"),
    "empty line": (_csv(CELL, ""), "one.csv:3:"),
    "count beyond int64": (_csv(CELL, "1.02,99999999999999999999,2,-3,4,0,-6,2"), "one.csv:3:"),
    "not UTF-8": (_replace("one.csv", lambda p: p.write_bytes(b"t_s,gx,gy,gz\n\xff\xfe,1,1,1\n")), "one.csv:2:"),
    "NUL bytes": (_replace("one.csv", lambda p: p.write_bytes(b"t_s,gx,gy,gz\n" + bytes(90))), "one.csv:2:"),
    "time back": (_csv(CELL, "0.9,1,2,-3,4,0,-6,23.5"), "one.csv:3:"),
    "long line": (_csv(CELL, "1.02" + "0" * 2**20), "one.csv:3:"),
    "large file": (_replace("one.csv", _sparse), "one.csv:"),
    "empty file": (_replace("one.csv", lambda p: p.write_bytes(b"")), "one.csv:1:"),
    "header alone": (_replace("one.csv", lambda p: p.write_text("t_s,gx,gy,gz\n")), "one.csv:2:"),
    "link outside": (_replace("one.csv", _link_outside), "campaign.toml:14:"),
    "link to itself": (_replace("one.csv", lambda p: p.symlink_to(p)), "campaign.toml:14:"),
    "path outside": (_toml('"one.csv"', '"../one.csv"'), "campaign.toml:14:"),
    "folder": (_replace("one.csv", Path.mkdir), "one.csv:"),
    "pipe": (_replace("one.csv", os.mkfifo), "one.csv:"),
    "other kind of file": (_toml('"one.csv"', '"one.txt"'), "campaign.toml:14:"),
    "damaged MCAP": (
        lambda f: [_toml('"one.csv"', '"one.mcap"')(f), (f / "one.mcap").write_bytes(b"no such magic bytes")],
        "one.mcap:",
    ),
    "no TOML": (_toml("[imu]", "[imu"), "campaign.toml:3:"),
    "TOML not UTF-8": (
        lambda f: (f / "campaign.toml").write_bytes(b'format = "campaign/1"\n\xff'),
        "campaign.toml:2:",
    ),
    "nested TOML": (_toml('"one.csv"', "[" * 5000), "campaign.toml:"),
    "other format": (_toml("campaign/1", "campaign/2"), "campaign.toml:1:"),
    "unknown key": (_toml("serial =", "seriel ="), "campaign.toml:5:"),
    "missing key": (_toml('serial = "S1"\n', ""), "campaign.toml:3:"),
    "text for a number": (_toml("= 0.02", '= "0.02"'), "campaign.toml:6:"),
    "nan in TOML": (_toml("31.17", "nan"), "campaign.toml:10:"),
    "latitude": (_toml("31.17", "131.17"), "campaign.toml:10:"),
    "position 13": (_toml("position = 1", "position = 13"), "campaign.toml:13:"),
    "two attitudes": (_toml("position = 1", 'position = 1\nup = "x_up"'), "campaign.toml:12:"),
    "half revolution": (_toml("revolutions = 3", "revolutions = 2.5"), "campaign.toml:19:"),
    "wrong start": (_toml("revolutions = 3", "revolutions = 3\nstart_position = 5"), "start_position"),
    "left-handed": (_toml("[site]", '[fixture]\nimu_axes = ["+y", "+x", "+z"]\n[site]'), "imu_axes"),
    "covariance": (
        _toml(
            "[site]",
            '[[fixture.face]]\nresting = "x_up"\nup_tilt_rad = [0, 0]\ncovariance_rad2 = [[1, 2], [2, 1]]\n[site]',
        ),
        "campaign.toml:9:",
    ),
    "measured cube of another name": (
        _toml("[site]", f"{MEASURED.replace('x.y', 'x.w')}[site]"),
        "'parallelism.x.w'",
    ),
    "measured cube, no covariance at all": (
        _toml("[site]", MEASURED.replace("[1e-12, 0.0]", "[1e-12, 2e-12]") + "[site]"),
        "covariance_rad2",
    ),
    "measured cube with certified faces": (
        _toml(
            "[site]", f'{MEASURED}[[fixture.face]]\nresting = "x_up"\nup_tilt_rad = [0, 0]\nstd_rad = 1e-6\n[site]'
        ),
        "[[fixture.face]]",
    ),
    "measured cube with an unknown key": (_toml("[site]", MEASURED + 'by = "us"\n[site]'), "campaign.toml:13:"),
    "wrap without cumulative": (_toml('"increments"', '"increments"\nwrap_bits = 16'), "wrap_bits"),
    "no step": (_replace("campaign.toml", lambda p: p.write_text(_HEAD)), "campaign.toml:"),
    "overlap": (_replace("turn.csv", lambda p: p.write_text("t_s,gx,gy,gz\n1.03,1,1,1\n")), "one.csv"),
}
_HEAD = """format = "campaign/1"
[imu]
model = "a"
serial = "b"
sample_period_s = 1
output = "rate"
[site]
latitude_deg = 0
"""


@pytest.mark.parametrize("why", REFUSED)
def test_a_folder_that_breaks_a_rule_is_refused_in_one_line(
    why: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    breaking, expected = REFUSED[why]
    breaking(folder)
    before = sorted(os.listdir(folder))
    code = cli.run(["solve", str(folder), "--json", str(folder / "out.json")])
    reported = capsys.readouterr()
    assert code == 3, reported.err
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    assert expected in reported.err
    assert sorted(os.listdir(folder)) == before


@pytest.mark.parametrize("why", ["text in a number", "pipe"])
def test_the_program_ends_with_3_and_no_traceback(why: str, folder: Path) -> None:
    breaking, expected = REFUSED[why]
    breaking(folder)
    command = [sys.executable, "-c", "from station.cli import main; main()", "solve", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)
    assert expected in done.stderr


def test_a_file_that_is_not_readable_is_refused(folder: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("root reads everything")
    (folder / "one.csv").chmod(0)
    assert cli.run(["solve", str(folder)]) == 3

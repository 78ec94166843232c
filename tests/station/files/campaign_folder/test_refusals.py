"""Each way to break a folder: exit 3, nothing written, and one line with file, line, found and expected."""

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
INSIDE = "expected the name of a file inside"
MEASURED = (
    '[fixture.measured]\nnames = ["parallelism.x.y", "skew.x.y"]\nvalue_rad = [1e-5, 2e-5]\n'
    "covariance_rad2 = [[1e-12, 0.0], [0.0, 1e-12]]\n"
)
REFUSED = {
    "no data file": (
        _replace("one.csv", lambda p: None),
        "campaign.toml:14: found 'one.csv', which does not exist",
    ),
    "no campaign.toml": (_replace("campaign.toml", lambda p: None), "found no campaign.toml, expected one"),
    "wrong header": (_csv("t_s,gx", "time,gx"), "one.csv:1: found column 'time', expected columns out of t_s,gx"),
    "unknown column": (_csv("temp_c", "temperature"), "one.csv:1: found column 'temperature'"),
    "column twice": (_csv("temp_c", "gx"), "one.csv:1: found column gx twice"),
    "no time": (_csv("t_s,gx", "gx"), "one.csv:1: found no column t_s"),
    "part of a triad": (_csv("gx,gy,gz", "gx,gy,aux_a"), "one.csv:1: found only gx,gy, expected all of gx,gy,gz"),
    "byte order mark": (_csv("t_s", "\ufefft_s"), "one.csv:1: found a byte order mark"),
    "text in a number": (
        _csv(CELL, "1.02,1,2,-3x,4,0,-6,23.5"),
        "one.csv:3: found '-3x' in column gz, expected an integer",
    ),
    "real count": (
        _csv(CELL, "1.02,1.5,2,-3,4,0,-6,23.5"),
        "one.csv:3: found '1.5' in column gx, expected an integer",
    ),
    "nan": (_csv(CELL, "nan,1,2,-3,4,0,-6,23.5"), "one.csv:3: found 'nan' in column t_s, expected a number"),
    "nan temperature": (_csv("-6,23.5", "-6,NaN"), "one.csv:2: found 'NaN' in column temp_c"),
    "infinity": (_csv(CELL, "inf,1,2,-3,4,0,-6,23.5"), "one.csv:3: found 'inf' in column t_s"),
    "hexadecimal": (_csv(CELL, "1.02,0x10,2,-3,4,0,-6,23.5"), "one.csv:3: found '0x10' in column gx"),
    "underscore": (_csv(CELL, "1.02,1_000,2,-3,4,0,-6,23.5"), "one.csv:3: found '1_000' in column gx"),
    "quotes": (_csv(CELL, '1.02,"1",2,-3,4,0,-6,23.5'), "one.csv:3: found '\"1\"' in column gx"),
    "blank": (_csv(CELL, "1.02, 1,2,-3,4,0,-6,23.5"), "one.csv:3: found ' 1' in column gx"),
    "empty count": (_csv(CELL, "1.02,,2,-3,4,0,-6,23.5"), "one.csv:3: found '' in column gx, expected an integer"),
    "decimal comma": (_csv(CELL, "1,02,1,2,-3,4,0,-6,23.5"), "one.csv:3: found 9 cells, expected 8 cells"),
    "cell missing": (_csv(CELL, "1.02,1,2,-3,4,0,-6"), "one.csv:3: found 7 cells, expected 8 cells"),
    "empty line": (_csv(CELL, ""), "one.csv:3: found an empty line"),
    "count beyond int64": (
        _csv(CELL, "1.02,99999999999999999999,2,-3,4,0,-6,2"),
        "one.csv:3: found a value too large",
    ),
    "real beyond float64": (
        _csv(CELL, "1e999,1,2,-3,4,0,-6,23.5"),
        "one.csv:3: found a value too large in column t_s",
    ),
    "not UTF-8": (
        _replace("one.csv", lambda p: p.write_bytes(b"t_s,gx,gy,gz\n\xff\xfe,1,1,1\n")),
        "one.csv:2: found '\\\\xff",
    ),
    "NUL bytes": (
        _replace("one.csv", lambda p: p.write_bytes(b"t_s,gx,gy,gz\n" + bytes(90))),
        "one.csv:2: found 1 cells",
    ),
    "time back": (
        _csv(CELL, "0.9,1,2,-3,4,0,-6,23.5"),
        "one.csv:3: found t_s 0.9 after 1, expected t_s that increases",
    ),
    "time stands": (_csv(CELL, "1.0,1,2,-3,4,0,-6,23.5"), "one.csv:3: found t_s 1 after 1"),
    "long line": (_csv(CELL, "1.02" + "0" * 2**20), "one.csv:3: found a line over 1 MiB"),
    "long header": (_csv("t_s", "t" * (2**20 + 1)), "one.csv:1: found a line over 1 MiB"),
    "large file": (
        _replace("one.csv", _sparse),
        "one.csv: found 4294967297 bytes, expected at most 4294967296 bytes",
    ),
    "empty file": (_replace("one.csv", lambda p: p.write_bytes(b"")), "one.csv:1: found no header"),
    "header alone": (_replace("one.csv", lambda p: p.write_text("t_s,gx,gy,gz\n")), "one.csv:2: found no row"),
    "link outside": (_replace("one.csv", _link_outside), INSIDE),
    "link to itself": (_replace("one.csv", lambda p: p.symlink_to(p)), "campaign.toml:14: found 'one.csv' ("),
    "path outside": (_toml('"one.csv"', '"../one.csv"'), INSIDE),
    "absolute path": (_toml('"one.csv"', '"/etc/one.csv"'), INSIDE),
    "NUL in a path": (_toml('"one.csv"', '"\\u0000.csv"'), INSIDE),
    "very long name": (_toml('"one.csv"', f'"{"a" * 5000}.csv"'), "campaign.toml:14: found"),
    "folder": (_replace("one.csv", Path.mkdir), "one.csv: found a folder, expected a regular file"),
    "pipe": (_replace("one.csv", os.mkfifo), "one.csv: found a device, pipe or socket, expected a regular file"),
    "other kind of file": (_toml('"one.csv"', '"one.txt"'), "campaign.toml:14: found file = 'one.txt'"),
    "damaged MCAP": (
        lambda f: [_toml('"one.csv"', '"one.mcap"')(f), (f / "one.mcap").write_bytes(b"no such magic bytes")],
        "one.mcap: found damage after message 0",
    ),
    "no TOML": (_toml("[imu]", "[imu"), "campaign.toml:3: found no TOML"),
    "TOML not UTF-8": (
        lambda f: (f / "campaign.toml").write_bytes(b'format = "campaign/1"\n\xff'),
        "campaign.toml:2: found byte 0xff, expected UTF-8",
    ),
    "nested TOML": (_toml('"one.csv"', "[" * 5000), "campaign.toml: found arrays nested too deep"),
    "large TOML": (_toml("[imu]", "#" * 2**20 + "\n[imu]"), "campaign.toml: found more than 1 MiB"),
    "other format": (
        _toml("campaign/1", "campaign/2"),
        "campaign.toml:1: found format = 'campaign/2', expected 'campaign/1'",
    ),
    "unknown key": (
        _toml("serial =", "seriel ="),
        "campaign.toml:5: found unknown key 'imu.seriel', expected one of model",
    ),
    "unknown table": (_toml("[site]", "[bench]\n[site]"), "campaign.toml:9: found unknown key 'bench'"),
    "missing key": (_toml('serial = "S1"\n', ""), "campaign.toml:3: found no imu.serial"),
    "text for a number": (_toml("= 0.02", '= "0.02"'), "campaign.toml:6: found imu.sample_period_s = '0.02'"),
    "nan in TOML": (_toml("31.17", "nan"), "campaign.toml:10: found site.latitude_deg = nan"),
    "latitude": (_toml("31.17", "131.17"), "campaign.toml:10: found site.latitude_deg = 131.17"),
    "position 13": (_toml("position = 1", "position = 13"), "campaign.toml:13: found dwell.position = 13"),
    "two attitudes": (
        _toml("position = 1", 'position = 1\nup = "x_up"'),
        "campaign.toml:12: found dwell with position = 1, up = 'x_up'",
    ),
    "half revolution": (
        _toml("revolutions = 3", "revolutions = 2.5"),
        "campaign.toml:19: found turn.revolutions = 2.5",
    ),
    "wrong start": (
        _toml("revolutions = 3", "revolutions = 3\nstart_position = 5"),
        "expected a start_position with x up",
    ),
    "left-handed": (
        _toml("[site]", '[fixture]\nimu_axes = ["+y", "+x", "+z"]\n[site]'),
        "expected imu_axes to be right-handed",
    ),
    "covariance": (
        _toml(
            "[site]",
            '[[fixture.face]]\nresting = "x_up"\nup_tilt_rad = [0, 0]\ncovariance_rad2 = [[1, 2], [2, 1]]\n[site]',
        ),
        "campaign.toml:9: found fixture.face with resting = 'x_up', expected covariance_rad2 to be symmetric and",
    ),
    "measured cube of another name": (
        _toml("[site]", f"{MEASURED.replace('x.y', 'x.w')}[site]"),
        "skew.y.z, not 'parallelism.x.w'",
    ),
    "measured cube without a row of covariance": (
        _toml("[site]", MEASURED.replace(", [0.0, 1e-12]", "") + "[site]"),
        "expected covariance_rad2 of 2 rows and columns",
    ),
    "measured cube, no covariance at all": (
        _toml("[site]", MEASURED.replace("[1e-12, 0.0]", "[1e-12, 2e-12]") + "[site]"),
        "expected covariance_rad2 to be symmetric and positive definite",
    ),
    "measured cube with a name twice": (
        _toml("[site]", MEASURED.replace("skew.x.y", "parallelism.x.y") + "[site]"),
        "expected each name once, and a value_rad for each",
    ),
    "measured cube with certified faces": (
        _toml(
            "[site]",
            f'{MEASURED}[[fixture.face]]\nresting = "x_up"\nup_tilt_rad = [0, 0]\nstd_rad = 1e-6\n[site]',
        ),
        "expected [[fixture.face]] or [fixture.measured], not both",
    ),
    "measured cube with an unknown key": (
        _toml("[site]", MEASURED + 'by = "us"\n[site]'),
        "campaign.toml:13: found unknown key 'fixture.measured.by', expected one of names, value_rad",
    ),
    "wrap without cumulative": (
        _toml('"increments"', '"increments"\nwrap_bits = 16'),
        "expected wrap_bits only beside",
    ),
    "no step": (_replace("campaign.toml", lambda p: p.write_text(_HEAD)), "campaign.toml: found no step"),
    "overlap": (
        _replace("turn.csv", lambda p: p.write_text("t_s,gx,gy,gz\n1.03,1,1,1\n")),
        "expected no overlap with one.csv",
    ),
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
    said = capsys.readouterr()
    assert code == 3, said.err
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert expected in said.err
    assert ": found " in said.err
    assert ", expected " in said.err
    assert sorted(os.listdir(folder)) == before


@pytest.mark.parametrize("why", ["text in a number", "large file", "link outside", "unknown key", "pipe"])
def test_the_program_ends_with_3_and_no_traceback(why: str, folder: Path) -> None:
    breaking, expected = REFUSED[why]
    breaking(folder)
    command = [sys.executable, "-c", "from station.cli import main; main()", "solve", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)
    assert expected in done.stderr


def test_a_file_that_is_not_readable_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if os.geteuid() == 0:
        pytest.skip("root reads everything")
    (folder / "one.csv").chmod(0)
    assert cli.run(["solve", str(folder)]) == 3
    assert "Permission denied" in capsys.readouterr().err

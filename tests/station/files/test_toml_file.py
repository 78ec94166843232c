"""Names and free text: what may stand on screens, pages and in names of files."""

import contextlib
import io
import random
import signal
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from procedures.errors import ErrorCode
from station import cli
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.toml_file import checked_name, checked_text, line_of, line_of_keys
from tests.benchmarks.hostile_values import judged
from tests.benchmarks.hostile_values.files import kinds
from tests.benchmarks.hostile_values.values import mutants, toml_of
from tests.refusals import refused


@pytest.mark.parametrize("name", ["FOG-3", "S0103", "Prüfling 7", "測定-1", "a.b", "x" * 64, "№ 5 (left)"])
def test_a_name_is_taken_as_it_is(name: str) -> None:
    assert checked_name(name) == name


@pytest.mark.parametrize(
    ("name", "reported"),
    [
        ("", "1 to 64"), (" ", "1 to 64"), ("a ", "1 to 64"), ("x" * 65, "1 to 64"), ("../../x", "no path"),
        ("a/b", "no path"), ("C:\\x", "no path"), (".hidden", "no path"), ("a\x00b", "U+0000"), ("a\nb", "U+000A"),
        ("\x1b[31m", "U+001B"), ("\u202egnp", "U+202E"), ("a\u200bb", "U+200B"), ("a\u2028b", "U+2028"),
        ("a\ud800b", "U+D800"), ("x" * 1001, "at most 1000"),
    ],
)  # fmt: skip
def test_what_is_no_name_is_reported(name: str, reported: str) -> None:
    with pytest.raises(ValueError, match=reported.replace("+", r"\+")):
        checked_name(name)


def test_free_text_may_be_long_and_hold_what_a_name_may_not() -> None:
    assert checked_text("1/2, see ../x " * 70) == "1/2, see ../x " * 70
    with pytest.raises(ValueError, match=r"U\+0007, U\+0008$"):
        checked_text("a\x08b\x07\x07")


TRIED = 12  # of a kind: those of seed 5; all of them are a proof
QUICK = ("plan", "limits", "effect", "laboratory", "faults", "scenario", "calibration_scenario")


@pytest.mark.parametrize("label", QUICK)
def test_no_value_is_answered_by_a_bug(label: str, tmp_path: Path) -> None:
    db = ["--db", str(tmp_path / "empty.db")]
    with contextlib.redirect_stdout(io.StringIO()):
        assert cli.run(["fixtures", "list", *db]) == 0
    kind = kinds(tmp_path, {}, {})[label]
    path, rng = tmp_path / kind.name, random.Random(5)
    path.write_text(toml_of(kind.tables))
    assert judged(kind, path) == (0, "")
    all_of_them = list(mutants(dict(kind.tables)))
    for done, tables in rng.sample(all_of_them, TRIED):
        path.write_bytes(toml_of(tables).encode("utf-8", "surrogatepass"))
        assert judged(kind, path)[1] == "", f"{done}: STATION_TRACEBACK=1 shows where"
    assert signal.alarm(0) == 0


TEXT = b"""format = "campaign/1"
[imu]
model = "FOG-3"
serial = "S1"
sample_period_s = 0.02
output = "increments"
[site]
latitude_deg = 31.17
magnetic_enu_ut = [-3.0, 34.0, -36.0]
[fixture]
imu_axes = ["+x", "+y", "+z"]
[[fixture.face]]
resting = "x_up"
up_tilt_rad = [1e-5, -2e-5]
covariance_rad2 = [[1e-10, 0], [0, 1e-10]]
[[dwell]]
position = 1
file = "one.csv"
"""
WORDS = [
    b"nan",
    b"[",
    b"]",
    b"=",
    b'"',
    b"\n",
    b"{}",
    b"true",
    b"1979-05-27",
    b"9" * 5000,
    b"'''",
    b"\xff",
    b"\\",
    b"#",
]
cuts = st.lists(
    st.tuples(st.integers(0, len(TEXT)), st.integers(0, 30), st.sampled_from(WORDS) | st.binary(max_size=4)),
    min_size=1,
    max_size=4,
)


@settings(max_examples=100)
@given(cuts)
def test_a_mutated_file_is_read_or_refused(cuts: list[tuple[int, int, bytes]]) -> None:
    content = TEXT
    for start, length, word in cuts:
        content = content[:start] + word + content[start + length :]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "campaign.toml").write_bytes(content)
        with contextlib.suppress(DataRefused):
            tables, _, _ = read_campaign_toml(Path(folder))
            assert tables.format == "campaign/1"


def test_the_line_of_a_key_is_that_of_its_own_table() -> None:
    lines = line_of_keys(TEXT.decode() + '[[dwell]]\nposition = 2\nfile = "two.csv"\n')
    assert line_of(("dwell", 1, "file"), lines) == 21
    assert line_of(("dwell", 0, "file"), lines) == 18
    assert line_of(("fixture", "face", 0, "covariance_rad2", 1, 0), lines) == 15
    assert line_of(("dwell", 1, "up"), lines) == 19
    assert line_of(("soak",), lines) == 1


def test_a_log_in_place_of_a_folder_names_the_command_that_reads_it(tmp_path: Path) -> None:
    (log := tmp_path / "quiet 0.csv").write_text("t,gx\n0,1\n")
    with refused(DataRefused, ErrorCode.FILE_MISSING, f"station diagnose '{log}'"):
        read_campaign_toml(log)

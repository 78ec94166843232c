"""A hostile ``campaign.toml`` never crashes; the line of a key is found."""

import contextlib
import tempfile
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.toml_reading import line_of, line_of_keys

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

"""A small campaign folder to break, and the campaigns of the shared data."""

from pathlib import Path

import pytest

from tests.paths import DATA

TOML = """\
format = "campaign/1"

[imu]
model = "FOG-3"
serial = "S1"
sample_period_s = 0.02
output = "increments"

[site]
latitude_deg = 31.17

[[dwell]]
position = 1
file = "one.csv"

[[turn]]
axis = "x"
direction = "+"
revolutions = 3
file = "turn.csv"
"""
HEADER = "t_s,gx,gy,gz,ax,ay,az,temp_c"


def rows(first_s: float, number: int = 5) -> str:
    return "".join(f"{first_s + 0.02 * i:.2f},1,2,-3,4,0,-6,23.5\n" for i in range(number))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A correct folder: a dwell at 1 s and a turn at 10 s."""
    path = tmp_path / "campaign"
    path.mkdir()
    (path / "campaign.toml").write_text(TOML)
    (path / "one.csv").write_text(f"{HEADER}\n{rows(1.0)}")
    (path / "turn.csv").write_text(f"{HEADER}\n{rows(10.0)}")
    return path


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The shared data folder, named by STATION_DATA; tests that need it are skipped without it."""
    path = DATA
    if not (path / "campaigns").is_dir():
        pytest.skip(f"no shared data at {path}: set STATION_DATA")
    return path

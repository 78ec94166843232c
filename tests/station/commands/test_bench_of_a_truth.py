"""`station fixtures example --truth`: what a planted unit needs so that it can be certified."""

from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import load_truth
from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import cube
from fixtures_db.fixtures import fixture_row
from fixtures_db.imu_models import limits_of
from fixtures_db.schema import SiteRow
from procedures.positions import FACES
from station import cli

TRUTH = """serial = "U-21"
latitude_deg = 48.1
height_m = 519.0
faces_rad = [[1e-5, 2e-5], [0, 3e-5], [-4e-5, 0], [0, 0], [5e-5, 1e-5], [0, -2e-5]]
"""


def _example(tmp_path: Path, text: str = TRUTH) -> int:
    (tmp_path / "unit.toml").write_text(text)
    return cli.run(["fixtures", "example", "--truth", str(tmp_path / "unit.toml"), "--db", str(tmp_path / "s.db")])


def test_the_bench_of_a_truth_is_added_once_and_its_options_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _example(tmp_path) == 0
    reported = capsys.readouterr().out
    truth = load_truth(TRUTH)
    names = "--cube SIM-CUBE-U-21 --slab SIM-SLAB-U-21"
    assert f"{names} --latitude 48.1 --height 519 --gravity {truth.local_gravity:.9g}" in reported
    assert _example(tmp_path) == 0
    assert capsys.readouterr().out == reported
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        faces = cube(session, "SIM-CUBE-U-21").faces
        site = fixture_row(session, SiteRow, "SIM-SITE-U-21")
        assert (site.latitude_deg, site.gravity_m_s2) == (48.1, truth.local_gravity)
        assert limits_of(session, truth.model)
    off = np.array([faces[face].up_tilt for face in FACES]) - truth.faces_rad
    assert 0 < np.max(np.abs(off)) < 5 * 5e-6


@pytest.mark.parametrize(("old", "new", "what"), [("5e-5, 1e-5", "5e-4, 1e-5", "cube"), ("48.1", "47.1", "site")])
def test_another_truth_of_the_same_serial_is_refused(
    old: str, new: str, what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _example(tmp_path) == 0
    assert _example(tmp_path, TRUTH.replace(old, new)) == 3
    assert f"{what} SIM-{what.upper()}-U-21" in capsys.readouterr().err

"""What a campaign folder says of its plan's mounting and of the unit's own error terms, listed and hashed."""

import hashlib
import re
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import text

from drivers.simulated.bench_control import BenchControl
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.imu_models import add_effect
from procedures.errors import ErrorCode
from station import cli
from station.errors import Altered
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
from station.files.campaign_setup import Setup
from station.files.sha256sums import SHA256SUMS, append_hash, sha256_of
from station.guide.campaign.campaign_tables import copy_effects
from station.guide.headless import record_headless
from station.guide.options import EngineOptions
from station.guide.simulated_operator import SimulatedOperator
from tests.fixtures_db.factory import unprotect
from tests.patience import paced
from tests.refusals import refused
from tests.station.effect_examples import DEAD_ZONE

PLAN = """format = "plan/1"
[fixture]
imu_axes = ["+y", "-x", "+z"]
[[dwell]]
position = 1
seconds = 4
[[dwell]]
position = 7
seconds = 4
"""


def test_a_folder_says_how_the_imu_was_mounted_and_holds_the_units_own_effects(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, folder = tmp_path / "plan.toml", tmp_path / "c"
    plan.write_text(PLAN)
    options = EngineOptions(root=tmp_path, plan=plan, warms_up=False, asks=False).engine()
    truth = replace(Truth.example(5), imu_axes=("+y", "-x", "+z"))
    with SimulatedDevice(truth, 5, speed=paced(100.0)) as device, open_db(tmp_path / "s.db") as database:
        with database.write() as session:
            row = add_effect(session, "gyroscope.dead_zone", DEAD_ZONE, truth.model, truth.serial)
            add_effect(session, "gyroscope.dead_zone", DEAD_ZONE.replace("1.0", "2.0"), truth.model, "of another")
        setup = Setup(url=device.url, latitude_deg=31.17, folder=str(folder), dwell_s=4.0)
        with closing(SimulatedOperator(BenchControl(device.control), 5.0)) as operator:
            record_headless(setup, replace(options, is_patient=False), database, operator, lambda view: None)
    found = read_campaign(folder)
    assert found.tables.fixture.imu_axes == ["+y", "-x", "+z"]
    assert [dwell.position for dwell in found.campaign.dwells] == [1, 7]  # by the faces of the cube
    assert [(one.name, one.text) for one in found.effects] == [("gyroscope.dead_zone", DEAD_ZONE)]
    assert found.files["effect_gyroscope_dead_zone.toml"] == row.effect_sha256
    verify = ["verify", str(folder), "--db", str(tmp_path / "s.db")]
    assert cli.run(verify) == 0
    kept = {name: (folder / name).read_bytes() for name in (CAMPAIGN_TOML, SHA256SUMS)}
    without = re.sub(r"\[effects\]\n(?:.+\n)+", "", kept[CAMPAIGN_TOML].decode())
    assert without != kept[CAMPAIGN_TOML].decode()
    (folder / CAMPAIGN_TOML).write_text(without)  # as if there never had been one
    append_hash(folder, CAMPAIGN_TOML, sha256_of(folder / CAMPAIGN_TOML))
    capsys.readouterr()
    assert cli.run(verify) == 1
    assert row.effect_sha256 in capsys.readouterr().err
    for name, content in kept.items():
        (folder / name).write_bytes(content)
    lines = kept[SHA256SUMS].decode().splitlines(keepends=True)
    (folder / SHA256SUMS).write_text("".join(line for line in lines if "effect_" not in line))
    assert cli.run(verify) == 1
    (folder / SHA256SUMS).write_bytes(kept[SHA256SUMS])
    (folder / "effect_gyroscope_dead_zone.toml").write_text(DEAD_ZONE.replace("1.0", "3.0"))
    assert cli.run(verify) == 1
    assert cli.run(["solve", str(folder)]) == 3


CHANGED = DEAD_ZONE.replace("1.0", "5.0")
SHA256 = hashlib.sha256(CHANGED.encode()).hexdigest()
ALTERED = (
    f"UPDATE effect_events SET definition = '{CHANGED}', effect_sha256 = '{SHA256}' WHERE id = 1",
    "UPDATE effect_events SET serial = 'S2' WHERE id = 1",
    "DELETE FROM effect_events WHERE id = 1",
)


@pytest.mark.parametrize("statement", ALTERED)
def test_what_was_altered_in_the_database_is_neither_copied_nor_shown_as_if_it_were_stored(
    statement: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with open_db(tmp_path / "s.db") as database:
        with database.write() as session:
            add_effect(session, "gyroscope.dead_zone", DEAD_ZONE, "FOG-3", "S1")
            add_effect(session, "gyroscope.dead_zone", DEAD_ZONE, "FOG-4", None)
            unprotect(session, "effect_events")
            session.execute(text(statement))
        with refused(Altered, ErrorCode.ALTERED):
            copy_effects(database, "FOG-3", "S1", tmp_path)
    assert not list(tmp_path.glob("effect_*"))
    for command in (["list"], ["show", "gyroscope.dead_zone"]):
        capsys.readouterr()
        assert cli.run(["effects", *command, "--db", str(tmp_path / "s.db")]) == 1
        (reported,) = capsys.readouterr().err.strip().splitlines()
        assert re.search(r"effect \d", reported)

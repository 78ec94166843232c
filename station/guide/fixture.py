"""The cube of a campaign, from the database."""

from collections.abc import Sequence
from dataclasses import replace

from fixtures_db.database import Database
from fixtures_db.face_certificates import cube
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.campaign.campaign import Fixture
from station.files.campaign_folder.campaign_schema import FaceTable, FixtureTable, MeasuredTable, axes_matrix
from station.files.campaign_folder.campaign_writing import measured_table


def cube_fixture(
    database: Database, cube_id: str | None, imu_axes: Sequence[str] = ()
) -> tuple[Fixture, FixtureTable]:
    """Return a cube of the database as a solve takes it and as ``campaign.toml`` says it.

    ``imu_axes`` says how the IMU is mounted in it, along x, y, z if it is empty.
    """
    fixture, table = _cube(database, cube_id)
    if not imu_axes:
        return fixture, table
    return replace(fixture, C_sb=axes_matrix(imu_axes)), table.model_copy(update={"imu_axes": list(imu_axes)})


def _cube(database: Database, cube_id: str | None) -> tuple[Fixture, FixtureTable]:
    if cube_id is None:
        return Fixture(), FixtureTable()
    with database.read() as session:
        fixture, side = cube(session, cube_id), fixture_row(session, CubeRow, cube_id).side_mm
    faces = [
        FaceTable.model_validate(
            {"resting": name, "up_tilt_rad": face.up_tilt.tolist(), "covariance_rad2": face.covariance.tolist()}
        )
        for name, face in fixture.faces.items()
    ]
    found = fixture.measured
    measured = None if found is None else MeasuredTable.model_validate(measured_table(found))
    return fixture, FixtureTable(id=cube_id, side_mm=side, face=faces, measured=measured)

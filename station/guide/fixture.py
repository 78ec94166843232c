"""The cube of a campaign, from the database."""

from fixtures_db.cubes import cube, cube_row
from fixtures_db.database import Database
from procedures.campaign import Fixture
from station.campaign_folder.schema import FaceTable, FixtureTable


def cube_fixture(database: Database, cube_id: str | None) -> tuple[Fixture, FixtureTable]:
    """Return a cube of the database as a solve takes it and as ``campaign.toml`` says it."""
    if cube_id is None:
        return Fixture(), FixtureTable()
    with database.read() as session:
        fixture, side = cube(session, cube_id), cube_row(session, cube_id).side_mm
    faces = [
        FaceTable.model_validate(
            {"resting": name, "up_tilt_rad": face.up_tilt.tolist(), "covariance_rad2": face.covariance.tolist()}
        )
        for name, face in fixture.faces.items()
    ]
    return fixture, FixtureTable(id=cube_id, side_mm=side, face=faces)

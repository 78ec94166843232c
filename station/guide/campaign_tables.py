"""A campaign's cube, site and procedure as ``campaign.toml`` says them, from the database and the set-up."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from fixtures_db.database import Database
from fixtures_db.fixture_measurements import cube
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.campaign.campaign import Fixture
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import (
    FaceTable,
    FixtureTable,
    ProcedureTable,
    SiteTable,
    axes_matrix,
    measured_table,
)
from station.files.campaign_setup import Setup

T = TypeVar("T", bound=BaseModel)


def cube_fixture(
    database: Database, cube_id: str | None, imu_axes: Sequence[str] = ()
) -> tuple[Fixture, FixtureTable]:
    """Return a cube of the database as a solve takes it and as ``campaign.toml`` says it.

    ``imu_axes`` says how the IMU is mounted in it, along x, y, z if it is empty.
    """
    fixture, table = Fixture(), FixtureTable()
    if cube_id is not None:
        with database.read() as session:
            fixture, side = cube(session, cube_id), fixture_row(session, CubeRow, cube_id).side_mm
        faces = [
            FaceTable.model_validate(
                {
                    "resting": name,
                    "up_tilt_rad": face.up_tilt.tolist(),
                    "covariance_rad2": face.covariance.tolist(),
                }
            )
            for name, face in fixture.faces.items()
        ]
        measured = None if fixture.measured is None else measured_table(fixture.measured)
        table = FixtureTable(id=cube_id, side_mm=side, face=faces, measured=measured)
    if not imu_axes:
        return fixture, table
    return replace(fixture, C_sb=axes_matrix(imu_axes)), table.model_copy(update={"imu_axes": list(imu_axes)})


def site_table(setup: Setup) -> SiteTable:
    """Return the set-up's site; raise `DataRefused` if a value is out of its range."""
    return _checked(
        SiteTable,
        {
            "latitude_deg": setup.latitude_deg, "longitude_deg": setup.longitude_deg, "height_m": setup.height_m,
            "gravity_m_s2": setup.gravity_m_s2, "gravity_std_m_s2": setup.gravity_std_m_s2,
        },
    )  # fmt: skip


def procedure_table(setup: Setup) -> ProcedureTable:
    """Return how well the set-up says headings and closures are; raise `DataRefused` out of range."""
    care = {"heading_std_deg": setup.heading_std_deg, "closure_std_deg": setup.closure_std_deg}
    return _checked(ProcedureTable, care)


def _checked(table: type[T], values: Mapping[str, object]) -> T:
    try:
        return table.model_validate(values)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        what = ".".join(str(part) for part in fault["loc"])
        found = f"{what} {fault['input']}"
        raise DataRefused("set-up", None, found, str(fault["msg"]), "correct the set-up") from error

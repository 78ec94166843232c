"""Cube, site, procedure and error terms as ``campaign.toml`` holds them, from the database and the set-up."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from fixtures_db.database import Database
from fixtures_db.fixture_measurements import cube
from fixtures_db.fixtures import fixture_row
from fixtures_db.imu_models import effects_in_force
from fixtures_db.schema import CubeRow
from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.geodesy import normal_gravity
from procedures.units import RAD_PER_ARCSEC, RAD_PER_DEG
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import (
    EffectsTable,
    FaceTable,
    FixtureTable,
    ProcedureTable,
    SiteTable,
    axes_matrix,
    measured_table,
    read_campaign_toml,
)
from station.files.campaign_setup import Setup
from station.files.effect_file import check_stored, stored_effect
from station.files.sha256sums import append_hash
from station.guide.options import load_setup

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
        found = {name: (one.up_tilt.tolist(), one.covariance.tolist()) for name, one in fixture.faces.items()}
        faces = [
            FaceTable.model_validate({"resting": name, "up_tilt_rad": tilt, "covariance_rad2": covariance})
            for name, (tilt, covariance) in found.items()
        ]
        measured = None if fixture.measured is None else measured_table(fixture.measured)
        table = FixtureTable(id=cube_id, side_mm=side, face=faces, measured=measured)
    if not imu_axes:
        return fixture, table
    return replace(fixture, C_sb=axes_matrix(imu_axes)), table.model_copy(update={"imu_axes": list(imu_axes)})


def site_table(setup: Setup) -> SiteTable:
    """Return the set-up's site; raise `DataRefused` if a value is out of its range."""
    return _table_of(setup, SiteTable)


def procedure_table(setup: Setup) -> ProcedureTable:
    """Return how well the set-up says headings and closures are; raise `DataRefused` out of range."""
    return _table_of(setup, ProcedureTable)


def _table_of(setup: Setup, table: type[T]) -> T:
    try:
        return table.model_validate(setup.model_dump(include=set(table.model_fields)))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        what = ".".join(str(part) for part in fault["loc"])
        found = f"{what} {fault['input']}"
        raise DataRefused("set-up", None, found, str(fault["msg"]), "correct the set-up") from error


def planned_bench(
    database: Database, cube: str | None, latitude: float | None, campaigns: Sequence[Path] = ()
) -> Campaign:
    """Return a campaign without steps, of a ``cube`` by its name and a ``latitude`` [deg], with the last set-up.

    Where none is given it is at the site of the first of ``campaigns`` that states one.

    Raises
    ------
    DataRefused, NotInDatabase
        If no latitude is known, or the cube is not.
    """
    setup = load_setup()
    if latitude is not None:
        setup = setup.model_copy(update={"latitude_deg": latitude})
    sites = (read_campaign_toml(folder)[0].site for folder in campaigns if latitude is None)
    stated = next((site for site in sites if site is not None), None)
    if setup.latitude_deg is None and stated is None:
        expected = "the latitude of the surface plate in deg"
        raise DataRefused("set-up", None, "no latitude", expected, "state it: --latitude DEG")
    at, care = stated or site_table(setup), procedure_table(setup)
    fixture, _ = cube_fixture(database, cube or None)
    return bench_of(at, care, fixture)


def bench_of(at: SiteTable, care: ProcedureTable, fixture: Fixture) -> Campaign:
    """Return a campaign without steps, as ``campaign.toml`` says site and care."""
    gravity = at.gravity_m_s2 or normal_gravity(at.latitude_deg * RAD_PER_DEG, at.height_m)
    sigma = ProcedureSigma(
        care.heading_std_deg * RAD_PER_DEG, care.closure_std_deg * RAD_PER_DEG,
        seat=care.seat_std_arcsec * RAD_PER_ARCSEC,
    )  # fmt: skip
    site = Site(at.latitude_deg * RAD_PER_DEG, gravity, at.gravity_std)
    return Campaign("", "", True, site, (), (), sigma, fixture)


def copy_effects(database: Database, model: str, serial: str, folder: Path) -> EffectsTable | None:
    """Return what ``campaign.toml`` is to list, its files written and hashed; None where nothing is in force.

    Raises
    ------
    DataRefused
        If what the database holds is no `effect/1`.
    Altered
        If an event of effects, of whatever unit, is not what was stored: what is in force is then not known.
    CannotWrite
        If the folder cannot be written.
    """
    with database.read() as session:
        check_stored(session)
        rows = effects_in_force(session, model, serial)
    names = [f"effect_{row.name.replace('.', '_')}.toml" for row in rows]
    for row, name in zip(rows, names, strict=True):
        stored_effect(row.definition, row.effect_sha256, row.name)
        replace_file(folder / name, row.definition.encode())
        append_hash(folder, name, row.effect_sha256)
    return EffectsTable(files=names, sha256=[row.effect_sha256 for row in rows]) if rows else None

"""The bench that a campaign is planned for: site and care of the last set-up, a cube of the database."""

from collections.abc import Sequence
from pathlib import Path

from fixtures_db.database import Database
from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.earth.geodesy import normal_gravity
from procedures.units import RAD_PER_ARCSEC, RAD_PER_DEG
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import ProcedureTable, SiteTable, read_campaign_toml
from station.guide.campaign_tables import cube_fixture, procedure_table, site_table
from station.guide.last_setup import load_setup


def planned_bench(
    database: Database, cube: str | None, latitude: float | None, campaigns: Sequence[Path] = ()
) -> Campaign:
    """Return a campaign without steps, of a ``cube`` by its name and a ``latitude`` [deg] beside the last set-up.

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
        raise DataRefused(
            "set-up", None, "no latitude", "the latitude of the surface plate in deg", "state it: --latitude DEG"
        )
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

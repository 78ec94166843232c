"""``station fixtures add``: cubes, certificates, surface plates, levels, sites and IMUs put into the database."""

from datetime import UTC, date, datetime
from typing import Annotated

import typer

from procedures.units import RAD_PER_ARCSEC
from station.commands import Database
from station.commands._options import argument, day_option, option, writing
from station.commands.command_table import Command

COMMANDS = (
    Command("cube", "A cube with the items of its drawing.", __name__),
    Command("certificate", "The measurement of a cube's face.", __name__),
    Command("slab", "A slab.", __name__),
    Command("level", "The measured level of a surface plate.", __name__),
    Command("site", "A site, with surveyed gravity.", __name__),
    Command("imu", "An IMU.", __name__),
)


Name = Annotated[str, argument("NAME", "Its name, which must be new.")]
Day = datetime | None
Certified = Annotated[Day, day_option("Day of its certificate.")]
Due = Annotated[Day, day_option("Last day of validity.")]
On = Annotated[datetime, day_option("Day on which it was measured.")]
By = Annotated[str, option("TEXT", "Who measured it, with which instrument.")]


def day(moment: Day) -> date | None:
    """Return the day of an option."""
    return None if moment is None else moment.date()


def past(on: Day) -> None:
    """Raise `typer.BadParameter` if a day of measuring is yet to come, here and in UTC."""
    today = max(date.today(), datetime.now(UTC).date())
    if on is not None and on.date() > today:
        raise typer.BadParameter(f"--on {on:%Y-%m-%d}: found a day in the future, expected {today} or before")


def due_after(on: datetime, due: Day) -> None:
    """Raise `typer.BadParameter` if something was due before it was measured."""
    if due is not None and due.date() < on.date():
        raise typer.BadParameter(
            f"--due {due:%Y-%m-%d}: found before the day of measuring, expected {on:%Y-%m-%d} or later"
        )


def above_zero(sigma_arcsec: tuple[float, float]) -> None:
    """Raise `typer.BadParameter` for a sigma that is none."""
    if not min(sigma_arcsec) > 0:
        raise typer.BadParameter(f"--sigma-arcsec {sigma_arcsec[0]:g} {sigma_arcsec[1]:g}: expected both above 0")


def noon(moment: datetime) -> datetime:
    """Return noon UTC of a day, the moment that stands for it."""
    return moment.replace(hour=12, tzinfo=UTC)


def cube(
    name: Name,
    side_mm: Annotated[float, option("MM", "Length of its edge [mm].")],
    tolerance: Annotated[
        list[str] | None, option("ITEM=MM", "An item of its drawing [mm]: t1 ... t10; give it for each item.")
    ] = None,
    certified: Certified = None,
    due: Due = None,
    db: Database = None,
) -> None:
    """Add a cube with the items of its drawing, named as in Yao, Hu, He 2018, table 2.

    t1, t2, t3 are the flatness of A, B, C; t4-1, t4-2 the perpendicularity of C to A and to B; t5, t6, t7 the
    flatness of the faces opposite to A, B, C; t8, t9, t10 their parallelism. `add certificate` adds the
    measurement of a face.

    Exit code 3 if the name is taken.

    Example: station fixtures add cube CUBE-7 --side-mm 400 --tolerance t1=0.04 --tolerance t8=0.02
    """
    items = dict(_item(text) for text in tolerance or ())
    with writing(db) as session:
        from fixtures_db.fixture_measurements import drawing
        from fixtures_db.fixtures import add_fixture
        from fixtures_db.schema import CubeRow

        dates = {"certificate_date": day(certified), "due_date": day(due)}
        add_fixture(session, CubeRow(id=name, side_mm=side_mm, tolerances=drawing(items), **dates))
    typer.echo(f"cube {name}: added")


def _item(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise typer.BadParameter(f"--tolerance {text}: expected an item and mm, such as t1=0.04") from None


def certificate(
    cube: Annotated[str, argument("CUBE", "The cube's name.")],
    resting: Annotated[str, argument("FACE", "The face: x_up, x_down ... z_down.")],
    tilt_arcsec: Annotated[
        tuple[float, float], option("1 2", "The up vector's components along the two other cube axes [arcsec].")
    ],
    sigma_arcsec: Annotated[tuple[float, float], option("1 2", "Their standard uncertainty [arcsec].")],
    on: On,
    by: By,
    correlation: Annotated[float, option("R", "Correlation of the two, -1 to 1.", min=-1, max=1)] = 0.0,
    due: Due = None,
    db: Database = None,
) -> None:
    """Append the measurement of a cube's face. It can never be changed; a later one replaces it.

    Exit code 3 if there is no cube of that name.

    Example: station fixtures add certificate CUBE-7 x_up --tilt-arcsec 1.2 -0.4 --sigma-arcsec 0.5 0.5 --on
    2026-03-04 --by "CMM 12, lab Weber" --due 2027-03-04
    """
    past(on)
    due_after(on, due)
    above_zero(sigma_arcsec)
    with writing(db) as session:
        import numpy as np

        from fixtures_db.fixture_measurements import certify_faces
        from procedures.campaign.campaign import FaceCertificate

        sigma = np.array(sigma_arcsec) * RAD_PER_ARCSEC
        shape = np.array([[1.0, correlation], [correlation, 1.0]])
        face = FaceCertificate(np.array(tilt_arcsec) * RAD_PER_ARCSEC, np.outer(sigma, sigma) * shape)
        certify_faces(session, cube, {resting: face}, source=by, measured_utc=noon(on), due_date=day(due))
    typer.echo(f"cube {cube}: certificate of {resting} added")


def slab(name: Name, certified: Certified = None, due: Due = None, db: Database = None) -> None:
    """Add a surface plate; `add level` adds its measured level.

    Exit code 3 if the name is taken.

    Example: station fixtures add slab SLAB-2 --certified 2026-03-04 --due 2027-03-04
    """
    with writing(db) as session:
        from fixtures_db.fixtures import add_fixture
        from fixtures_db.schema import SlabRow

        add_fixture(session, SlabRow(id=name, certificate_date=day(certified), due_date=day(due)))
    typer.echo(f"slab {name}: added")


def level(
    slab: Annotated[str, argument("SLAB", "The surface plate's name.")],
    tilt_arcsec: Annotated[
        tuple[float, float], option("EAST NORTH", "The up vector's components in the plate's axes [arcsec].")
    ],
    sigma_arcsec: Annotated[tuple[float, float], option("EAST NORTH", "Their standard uncertainty [arcsec].")],
    on: On,
    by: By,
    due: Due = None,
    db: Database = None,
) -> None:
    """Append the measured level of a surface plate. It can never be changed; a plate keeps every level.

    An east component above 0 means that the plate's east side is higher.

    Exit code 3 if there is no surface plate of that name.

    Example: station fixtures add level SLAB-2 --tilt-arcsec 2.1 -0.8 --sigma-arcsec 0.5 0.5 --on 2026-03-04 --by
    "electronic level 17, A. Weber" --due 2027-03-04
    """
    past(on)
    due_after(on, due)
    above_zero(sigma_arcsec)
    with writing(db) as session:
        from fixtures_db.fixture_measurements import add_level
        from fixtures_db.schema import SlabLevelRow

        east, north = (tilt * RAD_PER_ARCSEC for tilt in tilt_arcsec)
        std_east, std_north = (std * RAD_PER_ARCSEC for std in sigma_arcsec)
        level = SlabLevelRow(
            slab_id=slab, tilt_east_rad=east, tilt_north_rad=north, std_east_rad=std_east, std_north_rad=std_north,
            source=by, measured_utc=noon(on), due_date=day(due),
        )  # fmt: skip
        add_level(session, level)
    typer.echo(f"surface plate {slab}: level added")


def site(
    name: Name,
    latitude: Annotated[float, option("DEG", "Geodetic, north above 0 [deg].")],
    longitude: Annotated[float | None, option("DEG", "East above 0 [deg].")] = None,
    height: Annotated[float | None, option("M", "Above the ellipsoid [m].")] = None,
    gravity: Annotated[float | None, option("M/S2", "As surveyed [m/s2].")] = None,
    gravity_sigma: Annotated[float | None, option("M/S2", "Its standard uncertainty [m/s2].")] = None,
    gravity_by: Annotated[str, option("TEXT", "Who surveyed it, with which instrument.")] = "",
    gravity_on: Annotated[datetime | None, day_option("Day of the survey.")] = None,
    due: Due = None,
    db: Database = None,
) -> None:
    """Add the site of a surface plate, with surveyed gravity if available: value, standard uncertainty and source.

    Exit code 3 if the name is taken.

    Example: station fixtures add site LAB-1 --latitude 48.1374 --longitude 11.5755 --height 519 --gravity
    9.8072914 --gravity-sigma 2e-7 --gravity-by "gravimeter, survey 12" --due 2030-05-01
    """
    with writing(db) as session:
        from fixtures_db.fixtures import add_fixture
        from fixtures_db.schema import SiteRow

        site = SiteRow(id=name, latitude_deg=latitude, longitude_deg=longitude, height_m=height)
        if gravity is not None:
            if gravity_sigma is None or not gravity_by:
                raise typer.BadParameter("--gravity alone: expected --gravity-sigma and --gravity-by with it")
            site.gravity_m_s2, site.gravity_std_m_s2, site.gravity_source = gravity, gravity_sigma, gravity_by
            site.gravity_date, site.due_date = day(gravity_on), day(due)
        add_fixture(session, site)
    typer.echo(f"site {name}: added")


def imu(
    model: Annotated[str, argument("MODEL", "Its model.")],
    serial: Annotated[str, argument("SERIAL", "Its serial number.")],
    db: Database = None,
) -> None:
    """Add an IMU; a campaign adds its own IMU automatically.

    Exit code 3 if it exists.

    Example: station fixtures add imu FOG-3 0117
    """
    with writing(db) as session:
        from fixtures_db.campaigns import add_imu

        add_imu(session, model, serial)
    typer.echo(f"imu {model} {serial}: added")

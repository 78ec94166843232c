"""``station fixtures``: cubes, surface plates, sites and IMUs, what expires, limits, import and export."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from station.commands import Database
from station.commands._options import argument, day_option, flag, option, reading, signing_libraries, writing
from station.commands.command_table import Command

if TYPE_CHECKING:
    from fixtures_db.database import Database as OpenDatabase


COMMANDS = (
    Command("list", "List cubes, surface plates, sites and IMUs.", __name__),
    Command("show", "Show all data of one.", __name__),
    Command("add", "Add a cube, surface plate or site, or its measurement.", "station.commands.fixtures_add"),
    Command("import", "Import a TOML file or a folder of CSV files.", __name__),
    Command("export", "Export all as TOML or CSV.", __name__),
    Command("due", "List what expires.", __name__),
    Command("limits", "Limits of the parameters of an IMU model.", __name__),
    Command("example", "Add the bench of a simulated unit.", __name__),
    Command("measure", "Measure a cube with the IMUs calibrated in it.", "station.commands.fixtures_cube"),
    Command("tolerance", "Effect of a cube's tolerances on the calibration.", "station.commands.fixtures_cube"),
)


def list_(
    kind: Annotated[Literal["cube", "slab", "site", "imu"] | None, argument("[KIND]", "Only this kind.")] = None,
    db: Database = None,
) -> None:
    """List cubes, surface plates, sites and IMUs, a line each: size, measurements, due date.

    Lengths are in mm, tilts in arcsec, gravity in m/s2; measured values have their standard uncertainty.

    Example: station fixtures list slab
    """
    from station.results.fixtures.fixture_listing import KINDS

    with reading(db) as session:
        for name in KINDS if kind is None else (kind,):
            for line in KINDS[name].lines(session):
                typer.echo(f"{name} {line}" if kind is None else line)


def show(
    kind: Annotated[Literal["cube", "slab", "site", "imu"], argument("KIND", "Its kind.")],
    name: Annotated[str, argument("NAME", "Its name; an IMU's serial number.")],
    db: Database = None,
) -> None:
    """Show all that is known of a cube, surface plate (slab), site or imu.

    For a cube: the drawing's items in mm and each face's certificate in force. For a surface plate: every level,
    in arcsec. For a site: its position and surveyed gravity in m/s2. Measurements have their standard uncertainty,
    author and date.

    Exit code 3 if there is none of that name.

    Example: station fixtures show cube P1
    """
    from station.results.fixtures.fixture_listing import KINDS

    with reading(db) as session:
        typer.echo(KINDS[kind].description(session, name))


def import_(
    file: Annotated[
        Path, argument("IN", "A TOML file, a folder of CSV files, one such as slab.csv, or a certificate's XML.")
    ],
    trust: Annotated[
        list[Path] | None, option("ROOT.pem", "Of a certificate: a root that is trusted; repeatable.")
    ] = None,
    crl: Annotated[list[Path] | None, option("FILE", "A list of what it revoked; repeatable.")] = None,
    unsigned: Annotated[
        bool, flag("--unsigned", "Accept a certificate without signature; this is recorded.")
    ] = False,
    due: Annotated[datetime | None, day_option("Last day of validity, if the XML does not state it.")] = None,
    db: Database = None,
) -> None:
    """Import cubes, surface plates, sites, IMUs, certificates and levels of a fixtures/1, all or nothing.

    An entry that exists with the same values stays; with other values it is refused. Certificates and levels are
    appended: an earlier measurement never replaces a later one.

    FILE.xml is the digital calibration certificate (DCC) of a cube or a surface plate: its tilts with u = U / k
    and covariance enter the database, with laboratory, number and days. It must be signed by a trusted key.

    Exit code 1 if an export was changed since it was written; 3 if a row or certificate is refused, with its line.

    Example: station fixtures import fixtures.toml

    Example: station fixtures import W-17.xml --trust weber-root.pem --due 2027-03-04
    """
    if file.suffix.lower() == ".xml":
        _certificate(file, trust or [], crl or [], unsigned, due, db)
        return
    if trust or crl or unsigned or due:
        raise typer.BadParameter("--trust, --crl, --unsigned and --due are of a certificate's .xml; expected one")
    from fixtures_db.fixture_measurements import restore
    from station.files.database_files import read_csv, read_toml_file

    tables = read_toml_file(file) if file.suffix == ".toml" else read_csv(file)
    with writing(db, file) as session:
        added = restore(session, tables.rows)
    typer.echo(f"{file}: added {', '.join(f'{n} {name}' for name, n in added.items() if n) or 'nothing'}")


def _certificate(
    file: Path, roots: Sequence[Path], lists: Sequence[Path], unsigned: bool, due: datetime | None, db: str | None
) -> None:

    signing_libraries()
    from station.files.xml_document import read_document
    from station.results.certificate.signing.key_certificate import read_trust
    from station.results.certificate.signing.verification import verify_xml
    from station.results.fixtures.certificate_import import read_fixture, refuse_unproven, take_in

    found = verify_xml(read_document(file), file, read_trust(roots, lists))
    proven = refuse_unproven(found, file, unsigned)
    read = read_fixture(found.document, file)
    with writing(db, file) as session:
        text = take_in(session, read, proven, None if due is None else due.date(), file)
    typer.echo(f"{file}: added {text}")


def export(
    to: Annotated[Path, argument("OUT", "A file OUT.toml, or an empty folder for CSV files.")], db: Database = None
) -> None:
    """Write all cubes, surface plates, sites and IMUs, with every certificate and level, as fixtures/1.

    A name that ends in .toml is one TOML file, else a folder with a CSV file for each table. Both carry hashes:
    `station verify OUT` finds any change. An import into an empty database gives an equal one, including hashes.

    Example: station fixtures export fixtures.toml
    """
    from fixtures_db.fixture_measurements import dump
    from station.files.atomic_file import replace_file
    from station.files.database_files import to_toml, write_csv

    with reading(db) as session:
        rows = dump(session)
    if to.suffix == ".toml":
        replace_file(to, to_toml(rows).encode())
    else:
        write_csv(to, rows)
    typer.echo(f"{to}: {', '.join(f'{len(table)} {name}' for name, table in rows.items() if table)}")


def due(
    within: Annotated[int, option("DAYS", "How far ahead to look [days].", min=0)] = 60, db: Database = None
) -> None:
    """List what has expired or will expire within some days, the earliest first.

    Certificates of cubes and surface plates, surveys of sites, calibrations of IMUs. A campaign measured without
    cube, surface plate or certificate, or on an expired one, is "measured", not "calibrated".

    Example: station fixtures due --within 90
    """
    from datetime import date, timedelta

    from fixtures_db.fixtures import due as due_until

    today = date.today()
    with reading(db) as session:
        found = due_until(session, today + timedelta(days=within))
    for one in found:
        left = (one.date - today).days
        when = "expired on" if left < 0 else f"in {left} days, on"
        typer.echo(f"{one.kind} {one.name}: {when} {one.date}")
    if not found:
        typer.echo(f"nothing expires within {within} days")


def limits(
    model: Annotated[str | None, argument("[MODEL]", "The IMU model; else all are named.")] = None,
    import_file: Annotated[
        Path | None, option("FILE.toml", "Replace the model's limits by these.", names="--import")
    ] = None,
    example: Annotated[bool, flag("--example", "Print a sample limits file to edit.")] = False,
    db: Database = None,
) -> None:
    """Show the limits of an IMU model's parameters, or replace them with --import.

    The file holds a line model = "..." and a table [[limit]] for each parameter, or for all its axes at once:
    parameter (accelerometer.bias, gyroscope.scale_factor.x, residual.p_value ...), low, high or both, unit as the
    screens show it (ug, arcsec, deg/h, count/deg, count/(g s); g, rad and ppm are accepted too), and guard_band,
    the multiple of the value's own standard uncertainty u by which the limits are narrowed, 0 if not given.
    --example prints one.

    Exit code 3 if the model has no limits, or the file is no limits file.

    Example: station fixtures limits FOG-3 --example > limits.toml

    Example: station fixtures limits FOG-3 --import limits.toml
    """
    from fixtures_db.database import open_db

    if example:
        from station.files.limits_file import MODEL, example_limits

        typer.echo(example_limits(model or MODEL), nl=False)
        return
    if import_file is not None and model is None:
        raise typer.BadParameter("--import of what? expected `station fixtures limits MODEL --import FILE.toml`")
    with open_db(db) as database:
        if import_file is not None:
            typer.echo(_import(database, str(model), import_file))
        typer.echo(_limits(database, model))


def _import(database: "OpenDatabase", model: str, file: Path) -> str:
    from fixtures_db.imu_models import set_limits
    from station.errors import DataRefused
    from station.files.limits_file import limits_in
    from station.files.toml_file import read_text_file

    found, limits = limits_in(read_text_file(file), file)
    if found != model:
        raise DataRefused(file, None, f"limits of model {found!r}", f"{model!r} as on the command line")
    with database.write() as session:
        set_limits(session, model, limits)
    return f"{file}: stored"


def _limits(database: "OpenDatabase", model: str | None) -> str:
    from fixtures_db.errors import NotInDatabase
    from fixtures_db.imu_models import limited_models, limits_of
    from station.results.verdict import limit_in_words

    with database.read() as session:
        models = limited_models(session)
        if model is None:
            return "\n".join(models) or "no IMU model has limits"
        if model not in models:
            raise NotInDatabase("limits of IMU model", model, models)
        limits = limits_of(session, model)
    lines = [f"{model}: {len(limits)} limits"]
    return "\n".join([*lines, *(f"  {one.parameter}: {limit_in_words(one)}" for one in limits)])


def example(
    seed: Annotated[int | None, argument("SEED", "As in `station simulate --example SEED`.")] = None,
    truth: Annotated[Path | None, option("TOML", "As in `station simulate --truth TOML`.")] = None,
    db: Database = None,
) -> None:
    """Add cube, surface plate, site and limits of a simulated unit, so that it can end in PASS and be certified.

    Cube and surface plate are certified with the simulator's truth plus a random error of the stated uncertainty,
    the site with its gravity; each is marked as simulated. They are named after the seed, or the truth's serial.
    Existing entries stay.

    Exit code 3 if the truth is invalid, or the database has another bench for its serial.

    Example: station fixtures example 7

    Example: station fixtures example --truth unit.toml
    """
    from fixtures_db.database import open_db
    from station.commands.simulate import read_truth
    from station.demo.example_bench import GRAVITY_STD, add_bench_of, add_example

    if (seed is None) == (truth is None):
        raise typer.BadParameter("expected either SEED or --truth TOML")
    unit = read_truth(truth) if truth is not None else None
    with open_db(db) as database, database.write() as session:
        made = add_bench_of(session, unit) if unit is not None else add_example(session, seed or 0)
    names = f"{made.cube}, {made.slab}, {made.site}, limits of {made.truth.model}"
    typer.echo(f"{names}: simulated, for {made.truth.serial}; use")
    height = f"--height {made.truth.height_m:g} " if made.truth.height_m else ""
    typer.echo(
        f"  --cube {made.cube} --slab {made.slab} --latitude {made.truth.latitude_deg:g} {height}"
        f"--gravity {made.truth.local_gravity:.9g} --gravity-std {GRAVITY_STD:g}"
    )

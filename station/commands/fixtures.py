"""``station fixtures``: the cubes that the database knows, and the limits of IMU models."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from station.commands import Database

if TYPE_CHECKING:
    from fixtures_db.database import Database as OpenDatabase
    from fixtures_db.schema import CubeRow


def fixtures(
    action: Annotated[Literal["list", "show", "limits"], typer.Argument(help="What to do.")] = "list",
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="The cube to show, or the IMU model of the limits.")
    ] = None,
    import_file: Annotated[
        Path | None,
        typer.Option("--import", metavar="FILE.toml", help="Put these limits in the place of the model's."),
    ] = None,
    db: Database = None,
) -> None:
    """List the cube fixtures, or show one: side and tolerance items in mm, certified tilts in arcsec, due date.

    `limits` shows, or with --import replaces, what the parameters of an IMU model may be. The file holds a line
    model = "..." and a table [[limit]] for each parameter, or for all its axes at once: parameter
    (accelerometer.bias, gyroscope.scale_factor.x, residual.p_value ...), low, high or both, unit as in solution/1,
    and guard_band, the multiple of the value's own 1 sigma by which the limits are narrowed, 0 if not given.

    Exit code 3 if there is no cube of that name, or the file is no limits file.

    Example: station fixtures limits SIM-FOG3 --import limits.toml
    """
    if action == "show" and name is None:
        raise typer.BadParameter("show what? expected the name of a cube, as `station fixtures list` prints it")
    if import_file is not None and (action != "limits" or name is None):
        raise typer.BadParameter("--import of what? expected `station fixtures limits MODEL --import FILE.toml`")
    from fixtures_db.cubes import cube_row, cubes
    from fixtures_db.database import open_db

    with open_db(db) as database:
        if import_file is not None:
            typer.echo(_import(database, str(name), import_file))
        with database.read() as session:
            if action == "list":
                for row in cubes(session):
                    faces = {certificate.resting for certificate in row.certificates}
                    typer.echo(f"{row.id}: {row.side_mm:g} mm, {len(faces)} of 6 faces certified, {_due(row)}")
            elif action == "show":
                typer.echo(_description(cube_row(session, str(name))))
        if action == "limits":
            typer.echo(_limits(database, name))


def _import(database: "OpenDatabase", model: str, file: Path) -> str:
    from fixtures_db.limits import set_limits
    from station.errors import DataRefused
    from station.limits_toml import read_limits

    found, limits = read_limits(file)
    if found != model:
        raise DataRefused(file, None, f"limits of model {found!r}", f"{model!r} as on the command line")
    with database.write() as session:
        set_limits(session, model, limits)
    return f"{file}: stored"


def _limits(database: "OpenDatabase", model: str | None) -> str:
    from fixtures_db.errors import NotInDatabase
    from fixtures_db.limits import limited_models, limits_of

    with database.read() as session:
        models = limited_models(session)
        if model is None:
            return "\n".join(models) or "no IMU model has limits"
        if model not in models:
            raise NotInDatabase("limits of IMU model", model, models)
        limits = limits_of(session, model)
    lines = [f"{model}: {len(limits)} limits"]
    for one in limits:
        ends = [f"{word} {end:g}" for word, end in (("from", one.low), ("to", one.high)) if end is not None]
        guard = f", guard band {one.guard_band:g} sigma" if one.guard_band else ""
        lines.append(f"  {one.parameter}: {' '.join(ends)} {one.unit}{guard}")
    return "\n".join(lines)


def _due(row: "CubeRow") -> str:
    return "no due date" if row.due_date is None else f"due {row.due_date}"


def _description(row: "CubeRow") -> str:
    lines = [f"{row.id}: side {row.side_mm:g} mm, certificate {row.certificate_date or 'none'}, {_due(row)}"]
    for t in row.tolerances:
        against = f" to {t.reference_face}" if t.reference_face else ""
        lines.append(f"  {t.item}: {t.kind} of {t.face}{against} {t.tolerance_mm:g} mm")
    newest = {certificate.resting: certificate for certificate in row.certificates}
    arcsec = 180 * 3600 / 3.141592653589793  # per rad
    for resting, c in sorted(newest.items()):
        lines.append(
            f"  {resting}: up tilt {c.up_tilt_1_rad * arcsec:+.2f} +- {c.covariance_11_rad2**0.5 * arcsec:.2f}, "
            f"{c.up_tilt_2_rad * arcsec:+.2f} +- {c.covariance_22_rad2**0.5 * arcsec:.2f} arcsec "
            f"({c.source}, {c.measured_utc:%Y-%m-%d})"
        )
    return "\n".join(lines)

"""``station fixtures``: the cubes that the database knows."""

from typing import TYPE_CHECKING, Annotated, Literal

import typer

from station.commands import Database

if TYPE_CHECKING:
    from fixtures_db.schema import CubeRow


def fixtures(
    action: Annotated[Literal["list", "show"], typer.Argument(help="What to do.")] = "list",
    cube: Annotated[str | None, typer.Argument(metavar="CUBE", help="The cube to show.")] = None,
    db: Database = None,
) -> None:
    """List the cube fixtures, or show one: side and tolerance items in mm, certified tilts in arcsec, due date.

    Exit code 3 if there is no cube of that name.

    Example: station fixtures show P1
    """
    if action == "show" and cube is None:
        raise typer.BadParameter("show what? expected the name of a cube, as `station fixtures list` prints it")
    from fixtures_db.cubes import cube_row, cubes
    from fixtures_db.database import open_db

    with open_db(db) as database, database.read() as session:
        if action == "list":
            for row in cubes(session):
                faces = {certificate.resting for certificate in row.certificates}
                typer.echo(f"{row.id}: {row.side_mm:g} mm, {len(faces)} of 6 faces certified, {_due(row)}")
        else:
            typer.echo(_description(cube_row(session, str(cube))))


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

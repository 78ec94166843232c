"""``station history``: a unit's stored calibrations and how it drifted between them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from station.commands import Database

if TYPE_CHECKING:
    from fixtures_db.schema import CalibrationRow

HEAD = ("model", "accepted_utc", "status", "verdict")
MAIN = ("scale_factor", "bias")  # shown in the list; the file holds misalignment too


def history(
    serial: Annotated[str, typer.Argument(metavar="SERIAL", help="The unit's serial number.")],
    json: Annotated[
        Path | None, typer.Option("--json", metavar="OUT", help="Write history/1 here instead of a list.")
    ] = None,
    db: Database = None,
) -> None:
    """List every stored calibration of a unit: when, verdict, status, the main parameters with 1 sigma.

    Below each stands its drift from the one before, in sigmas of both together. Scale factors are in count/(g s)
    and count/deg, biases in ug and deg/h (in g and deg/h in the file).

    Exit code 3 if no calibration of that serial number is stored.

    Example: station history SIM-7
    """
    from fixtures_db.database import open_db
    from fixtures_db.errors import NotInDatabase
    from fixtures_db.history import calibrated_serials
    from fixtures_db.history import history as stored

    with open_db(db) as database, database.read() as session:
        rows = list(stored(session, serial))
        if not rows:
            raise NotInDatabase("calibration of serial number", serial, calibrated_serials(session))
        document = {"format": "history/1", "serial": serial, "calibrations": _entries(rows)}
    if json is None:
        typer.echo(_text(document))
    else:
        from station.solution_json import write_solution

        write_solution(json, document)


def _entries(rows: "list[CalibrationRow]") -> list[dict[str, Any]]:
    """Return each calibration as history/1; drift is against the one before of the same model."""
    from json import loads

    from station.solution_parameters import applied, parameters, shifts

    entries, last = list[dict[str, Any]](), dict[str, dict[str, Any]]()
    for row in rows:
        document = loads(row.document)
        found = applied(parameters(document))
        before = applied(parameters(last.get(document["model"], {})))
        entries.append(
            {
                "sha256": row.sha256,
                **{
                    key: document[key] for key in ("model", "accepted_utc", "status", "verdict") if key in document
                },
                "parameters": {
                    name: {"value": one.value, "std": one.std, "unit": one.unit} for name, one in found.items()
                },
                "drift": {
                    name: {"shift": one.shift, "shift_sigma": one.sigmas}
                    for name, one in shifts(found, before).items()
                },
            }
        )
        last[document["model"]] = document
    return entries


def _text(document: dict[str, Any]) -> str:
    from station.solution_parameters import Parameter, Shift, largest, shown, shown_sigma

    lines = list[str]()
    for entry in document["calibrations"]:
        verdict = entry.get("verdict", "not judged").replace("_", " ")
        when = entry["accepted_utc"][:16].replace("T", " ")
        lines.append(f"{when} UTC  {entry['model']}  {verdict}, {entry['status']}  {entry['sha256'][:12]}")
        found = {name: Parameter(name, **values) for name, values in entry["parameters"].items()}
        moved = {
            name: Shift(found[name], one["shift"], one["shift_sigma"]) for name, one in entry["drift"].items()
        }
        for name, one in found.items():
            if name.split(".")[1] in MAIN:
                value, unit = shown(one)
                drift = f"   {moved[name]}" if name in moved else ""
                lines.append(f"  {one.title:<30}{value:>16} +- {shown_sigma(one)} {unit}{drift}")
        if (most := largest(moved)) is not None:
            lines.append(f"  moved most: {most.parameter.title}, {most}")
    return "\n".join(lines)

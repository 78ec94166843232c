"""``station history``: what the stored calibrations say about a unit, or about all units of a model."""

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._options import argument, day_option, option, reading

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from station.results.history.population import Population
    from station.results.history.unit_history import UnitHistory


def history(
    serial: Annotated[str | None, argument("SERIAL", "The unit's serial number.")] = None,
    population: Annotated[
        str | None, option("MODEL", "Compare all units of this model instead of one unit.")
    ] = None,
    at: Annotated[datetime | None, day_option("Predict for this date, not the due date.")] = None,
    json: Annotated[Path | None, option("OUT", "Write history/1 or population/1 here.")] = None,
    html: Annotated[Path | None, option("FILE", "Write a page with charts.")] = None,
    db: Database = None,
) -> None:
    """List every stored calibration of a unit with its drift, or find the units of a model that differ.

    Of a unit: every calibration with standard uncertainty u and the change from the one before in units of their
    combined u; then per parameter the turn-on repeatability, the control chart's last z, the value predicted for
    the due date with its 95 % interval, and the probability of being outside the limits of the model. Of a model:
    units that differ from the others, and cubes, surface plates, sites and operators that shift a parameter.
    docs/how-to/history.md has the equations.

    Scale factors are in count/(g s) and count/deg, biases in ug and deg/h (in g and deg/h in files), misalignments
    in arcsec (1 in files). Without --json or --html the result is text.

    Exit code 3 if there is no calibration of that serial number or model.

    Example: station history SIM-7 --html history.html
    """
    if (serial is None) == (population is None):
        raise typer.BadParameter("expected a serial number or --population MODEL, one of the two")
    if population is not None and at is not None:
        raise typer.BadParameter("--at belongs to a serial number, a population is not predicted")
    from station.files.atomic_file import replace_file, write_json
    from station.results.result_formats import document_of

    with reading(db) as session:
        found = _of_unit(session, serial, at) if serial is not None else _of_model(session, str(population))
    if json is not None:
        write_json(json, document_of(found))
        typer.echo(f"{json}: {found.format} of {serial or population}")
    if html is not None:
        replace_file(html, _page(found).encode())
        typer.echo(f"{html}: history of {serial or population}")
    if json is None and html is None:
        typer.echo(_text(found))


def _of_unit(session: "Session", serial: str, at: datetime | None) -> "UnitHistory":
    from datetime import UTC

    from fixtures_db.errors import NotInDatabase
    from fixtures_db.imu_models import limits_of
    from fixtures_db.stored_calibrations import calibrated_serials, stored_runs
    from station.results.history.unit_history import unit_history

    runs = stored_runs(session, serial=serial)
    if not runs:
        raise NotInDatabase("calibration of serial number", serial, calibrated_serials(session))
    asked = None if at is None else at.replace(tzinfo=UTC)
    if asked is not None and asked < (newest := max(run.ended for run in runs)):
        raise typer.BadParameter(f"--at {asked:%Y-%m-%d}: expected a date after the newest, {newest:%Y-%m-%d}")
    limits = {model: limits_of(session, model) for model in {run.model for run in runs}}
    return unit_history(serial, runs, limits, asked)


def _of_model(session: "Session", model: str) -> "Population":
    from fixtures_db.errors import NotInDatabase
    from fixtures_db.stored_calibrations import calibrated_models, stored_runs
    from station.results.history.population import population

    runs = stored_runs(session, model=model)
    if not runs:
        raise NotInDatabase("calibration of model", model, calibrated_models(session))
    return population(model, runs)


def _text(found: "UnitHistory | Population") -> str:
    from station.results.history.population import Population, population_text
    from station.results.history.unit_history_text import history_text

    return population_text(found) if isinstance(found, Population) else history_text(found)


def _page(found: "UnitHistory | Population") -> str:
    from station.results.history.history_page import population_page, unit_page
    from station.results.history.population import Population

    return population_page(found) if isinstance(found, Population) else unit_page(found)

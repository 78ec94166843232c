"""``station tune``: gains of the mixing law from a log with truth."""

from pathlib import Path
from typing import Annotated

import typer

from procedures.units import STANDARD_GRAVITY
from station.commands import Database
from station.commands._options import argument, hand_out, option


def tune(
    log: Annotated[Path, argument("LOG", "A CSV file of attitude-log/1 with truth.")],
    aid: Annotated[str, option("--aid", "AID", "none, airspeed or a paper- aid of `station attitude`.")] = "none",
    gains: Annotated[
        bool, option("--gains", "", "Search K1 and K2 separately instead of one time constant.")
    ] = False,
    gravity: Annotated[float, option("--gravity", "M_S2", "", min=9.7, max=9.9)] = STANDARD_GRAVITY,
    json: Annotated[Path | None, option("--json", "OUT", "Write tuning/1 here instead of the curve.")] = None,
    db: Database = None,
) -> None:
    """Choose the complementary filter's time constant [s] or gains [1/s] by cross-validation; show the curve.

    The filter runs over the log with every candidate; its inclination error against the log's truth is computed
    over scored rows. Each fifth of the rows is evaluated with the candidate that the other four choose.

    Exit code 3 if the log breaks a rule of attitude-log/1, 5 if it has no truth.

    Example: station tune drive.csv --aid airspeed
    """
    from procedures.attitude.attitude_estimate import AID_COLUMN, AIDS, takes_gains
    from station.attitude.attitude_log import read_log
    from station.files.atomic_file import refuse_own

    refuse_own((json,), (log,))
    lawful = [name for name in AIDS if takes_gains(name)]
    if aid not in lawful:
        raise typer.BadParameter(f"found {aid!r}, expected one of {', '.join(lawful)}", param_hint="--aid")
    read = read_log(log)
    if aid in AID_COLUMN and getattr(read, AID_COLUMN[aid]) is None:
        raise typer.BadParameter(f"{aid} needs {AID_COLUMN[aid]}, which {log} has not", param_hint="--aid")
    from procedures.attitude.gain_tuning import grid_of_gains, grid_of_taus
    from procedures.attitude.gain_tuning import tune as search
    from station.attitude.tuning_json import tuning_document, tuning_text

    found = search(read, aid, grid_of_gains() if gains else grid_of_taus(), gravity)
    document = tuning_document(found, aid, by_tau=not gains)
    hand_out(document, tuning_text(document), json, f"gains for {log}, tuning/1")

"""``station resume``: continue a campaign that was left, or that a kill or a power cut ended."""

from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._guided import (
    Hands,
    Headless,
    MoveS,
    Plain,
    Quiet,
    Slow,
    Store,
    Tremor,
    WarmUp,
    Web,
    WebPort,
)
from station.commands._options import argument, option


def resume(
    folder: Annotated[
        Path | None, argument("[FOLDER]", "The campaign's folder; else the newest unfinished.")
    ] = None,
    device: Annotated[str, option("--device", "URL", "Where the IMU is now, if not at the port it had.")] = "",
    list_only: Annotated[bool, option("--list", "", "List the unfinished campaigns.")] = False,
    warm_up: WarmUp = True,
    headless: Headless = False,
    store: Store = False,
    plain: Plain = False,
    web: Web = False,
    port: WebPort = 8000,
    slow: Slow = False,
    quiet: Quiet = False,
    hands: Hands = None,
    move_s: MoveS = 45.0,
    tremor: Tremor = False,
    db: Database = None,
) -> None:
    """Resume an unfinished campaign on the same IMU.

    All accepted steps are kept. The unit is recognised by its serial number, or by its rates and noise; then the
    station asks for confirmation. The solution is identical to that of an uninterrupted campaign.

    Exit codes as `calibrate`; 3 if there is nothing to resume or its files were changed.

    Example: station resume --list
    """
    from fixtures_db.database import open_db
    from station.commands._guided import Display, campaigns_root, guide
    from station.errors import DataRefused
    from station.guide.last_setup import load_setup
    from station.guide.options import EngineOptions
    from station.guide.start_screen import unfinished_campaigns
    from station.guide.view import OperatorCommand

    with open_db(db) as database:
        found = unfinished_campaigns(database)
    if list_only:
        for each in found:
            typer.echo(f"{each.title}, {each.state}: {each.folder}")
        return
    if folder is not None and not any(Path(each.folder) == folder.resolve() for each in found):
        raise DataRefused(folder, None, "no unfinished campaign", "one that `station resume --list` names",
                          "it was cancelled or stored, or it is in another database (--db)")  # fmt: skip
    free = [Path(each.folder) for each in found if each.state == "free"]
    if folder is None and not free:
        raise DataRefused("database", None, "no unfinished campaign", "one that is free", "begin with `calibrate`")
    which = str(folder.resolve() if folder is not None else free[0])
    setup = load_setup().model_copy(update={"url": device})  # of a form, should this campaign be refused
    options = EngineOptions(
        root=campaigns_root(), database=db, setup=setup, hands=hands, move_s=move_s, tremor=tremor,
        asks=not headless, warms_up=not headless and warm_up, first=OperatorCommand(verb="resume", folder=which),
    )  # fmt: skip
    screen = Display(headless=headless, plain=plain, web=web, port=port, slow=slow, quiet=quiet, stores=store)
    raise typer.Exit(guide(options, screen))

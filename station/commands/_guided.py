"""What `calibrate` and `resume` share: an engine, its screen or lines of text, and the exit code.

Where nobody can type, as input is no terminal or has ended, a question that only an answer could resolve ends the
program with the exit code and the reason that `--headless` would have.
"""

import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import platformdirs
import typer
from pydantic import BaseModel, ValidationError

from station.commands._options import Plain, Quiet, Slow, flag, option
from station.errors import CANCELLED
from station.files.campaign_setup import Setup
from station.files.toml_file import expected_of
from station.guide.client import EngineConnection
from station.guide.view import ENDED_STAGES, VERDICT_STAGES, CalibrationView, OperatorCommand

if TYPE_CHECKING:
    from station.guide.options import EngineOptions


FAIL, CANNOT_GO_ON = 1, 2
SITE_FIELDS = ("latitude_deg", "longitude_deg", "height_m", "gravity_m_s2", "gravity_std_m_s2")
PROCEDURE_FIELDS = ("heading_std_deg", "closure_std_deg")


@dataclass(frozen=True, slots=True)
class GuideOptions:
    """How a campaign is looked at, ``headless`` by nobody, else by screen, lines of text or browser; its hands."""

    warm_up: Annotated[
        bool, flag("--warm-up/--no-warm-up", "Wait until the unit has warmed up. Not with --headless.")
    ] = True
    headless: Annotated[bool, flag("--headless", "Lines of text, no questions, no warm-up.")] = False
    store: Annotated[bool, flag("--store", "With --headless: store the calibration.")] = False
    plain: Plain = False
    web: Annotated[bool, flag("--web", "The same screen in a browser on this computer.")] = False
    port: Annotated[int, option("PORT", "Port of --web; 0: any free one.", min=0, max=65535)] = 8000
    slow: Slow = False
    quiet: Quiet = False
    hands: Annotated[str | None, option("HOST:PORT", "Control address of a simulated device.")] = None
    move_s: Annotated[float, option("S", "Device time a simulated move takes.")] = 45.0
    tremor: Annotated[bool, flag("--tremor", "With --hands: move with tremor and pauses, like real hands.")] = (
        False
    )

    def engine(self, database: str | None, setup: Setup, **more: Any) -> "EngineOptions":
        """Return the options of the engine that is looked at so."""
        from station.guide.options import EngineOptions

        return EngineOptions(
            root=campaigns_root(), database=database, setup=setup, hands=self.hands, move_s=self.move_s,
            tremor=self.tremor, asks=not self.headless, warms_up=not self.headless and self.warm_up, **more,
        )  # fmt: skip


def campaigns_root() -> Path:
    """Return the default folder of campaigns."""
    return platformdirs.user_data_path("fog-station") / "campaigns"


def set_up(setup: Setup, given: Mapping[str, Any]) -> Setup:
    """Return ``setup`` with what the command line gives in its place; what is out of range is wrong usage."""
    known = {name: value for name, value in given.items() if value not in {None, ""}}
    if not known.keys() & {*SITE_FIELDS, *PROCEDURE_FIELDS}:
        return setup.model_copy(update=known)
    # numerics: a form need not wait for them
    from station.files.campaign_folder.campaign_schema import ProcedureTable, SiteTable

    _check(SiteTable, latitude_deg=0.0, **{n: known[n] for n in SITE_FIELDS[1:] if n in known})
    if "latitude_deg" in known:
        _check(SiteTable, latitude_deg=known["latitude_deg"])
    _check(ProcedureTable, **{n: known[n] for n in PROCEDURE_FIELDS if n in known})
    return setup.model_copy(update=known)


def _check(table: type[BaseModel], **options: object) -> None:
    """Raise `typer.BadParameter` for an option that a table of ``campaign.toml`` refuses."""
    try:
        table(**options)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        name = ".".join(str(part) for part in fault["loc"])
        raise typer.BadParameter(f"{name} {fault['input']}: expected {expected_of(fault)}") from None


def guide(options: "EngineOptions", screen: GuideOptions) -> int:
    """Run an engine until its campaign has ended or the operator has left; return the exit code."""
    if not (screen.headless or screen.plain or screen.web) and not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise typer.BadParameter(
            "the screen needs a terminal; --plain writes lines of text, --headless asks nothing"
        )
    _refuse_addresses(options)
    options.engine()  # a plan that cannot be read is refused here; a database by the engine
    if screen.headless:
        from fixtures_db.database import open_db
        from station.guide.headless import run_headless
        from station.guide.plain_screen import PlainScreen

        show = PlainScreen(typer.echo, rings=False).show
        with open_db(options.database) as database:
            return _code(run_headless(options, database, show, stores=screen.store))
    from station.guide.client import engine_process

    with engine_process(options) as socket:
        return _code(_serve(socket, screen) if screen.web else _look(socket, screen, options))


def _refuse_addresses(options: "EngineOptions") -> None:
    """Refuse what is no address, and hands that do not answer, before anything begins.

    Raises
    ------
    BadDeviceUrl, HandsLost
        What is wrong with an address.
    """
    from station.stream.connected_unit import imu_address, receiver_address

    first = options.first
    setup, url = (first.setup if first and first.setup else options.setup), first.url if first else ""
    if url or setup.url:
        imu_address(url or setup.url)
    if setup.gnss:
        receiver_address(setup.gnss)
    if (operator := options.operator()) is not None:
        operator.reach()
        operator.close()


def _serve(socket: Path, screen: GuideOptions) -> CalibrationView:
    """Serve the engine to browsers until its campaign has ended, or the server was stated to."""
    from station.tui.web import serve

    with EngineConnection(socket) as connection:

        def stop_when_over() -> None:
            if connection.view.stage in ENDED_STAGES:
                connection.changed = _nothing
                os.kill(os.getpid(), signal.SIGTERM)

        connection.changed = stop_when_over
        command = [sys.executable, "-P", "-m", "station.tui", str(socket)]
        serve(command, _announce, port=screen.port, report=lambda: _report(connection.view))
        connection.changed = _nothing
        return connection.view


def _nothing() -> None:
    pass


def _announce(url: str) -> None:
    typer.echo(
        "Open this address in a browser on this computer. Anyone who has it can control the bench: keep it secret."
    )
    typer.echo(
        "Each tab shows the same campaign, and closing one changes nothing; Ctrl-C here stops the campaign."
    )
    typer.echo(url)


def _report(view: CalibrationView) -> Path | None:
    return Path(view.verdict.report) if view.verdict and view.verdict.report else None


def _look(socket: Path, screen: GuideOptions, options: "EngineOptions") -> CalibrationView:
    changed = threading.Event()
    with EngineConnection(socket, changed.set) as connection:
        if screen.plain:
            return follow(connection, changed, options.first, rings=not screen.quiet)
        from station.tui import run_screens

        run_screens(connection, slow=screen.slow, quiet=screen.quiet)
        return connection.view


def _code(view: CalibrationView) -> int:
    """Return the exit code of a campaign that ended so."""
    if view.stage == "failed":
        typer.echo(f"{view.error}; {view.hint}" if view.hint else view.error, err=True)
        return view.code or CANNOT_GO_ON
    if view.code or view.stage == "cancelled":
        typer.echo(view.line, err=True)
        return view.code or CANCELLED
    return FAIL if view.verdict is not None and view.verdict.word == "FAIL" else 0


UNANSWERED_S = 60.0  # with a question that nobody can answer: it may go away, as when the cube is put elsewhere


def say(text: str) -> None:
    """Write a text; on a terminal no word of it is broken at the last column."""
    if sys.stdout.isatty():
        from station.guide.plain_screen import between_words

        text = between_words(text, shutil.get_terminal_size().columns)
    typer.echo(text)


def follow(
    connection: EngineConnection, changed: threading.Event, first: OperatorCommand | None, *, rings: bool
) -> CalibrationView:
    """Write lines and take keys until the campaign has ended or nobody can take it further; return that view."""
    from station.guide.plain_screen import PlainScreen, listen

    asks = sys.stdin.isatty()
    screen, is_deaf = PlainScreen(say, rings=rings, asks=asks), threading.Event()

    def hear() -> None:
        listen(connection, sys.stdin, say, first)
        is_deaf.set()
        changed.set()

    threading.Thread(target=hear, daemon=True).start()
    asked_since = 0.0
    while True:
        changed.wait(1.0)
        changed.clear()
        view = connection.view
        screen.show(view)
        if view.stage in ENDED_STAGES:
            return view
        if view.start and view.start.refused and (not asks or is_deaf.is_set()):
            return view.model_copy(
                update={"stage": "failed", "error": view.start.refused, "code": view.start.refused_code}
            )
        asked_since = (asked_since or time.monotonic()) if view.question else 0.0
        if is_deaf.is_set():
            is_stuck = bool(asked_since) and time.monotonic() - asked_since > UNANSWERED_S
            if is_stuck:
                typer.echo("no answer is possible: the input has ended", err=True)
            if is_stuck or view.stage in VERDICT_STAGES:
                connection.send(OperatorCommand(verb="leave"))

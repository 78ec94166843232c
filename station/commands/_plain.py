"""`--plain`: lines out, lines of input in, and an end in every case.

Who sits at a terminal is asked again. Where nobody can type (input is no terminal, or at its end), what only an
answer could take further ends the program, with the exit code and the reason that `--headless` would have.
"""

import shutil
import sys
import threading
import time

import typer

from station.guide.client import EngineConnection
from station.guide.plain_screen import PlainScreen, between_words, listen
from station.guide.view import ENDED_STAGES, VERDICT_STAGES, CalibrationView, OperatorCommand

UNANSWERED_S = 60.0  # with a question that nobody can answer: it may go away, as when the cube is put elsewhere


def say(text: str) -> None:
    """Write a text; on a terminal no word of it is broken at the last column."""
    if sys.stdout.isatty():
        text = between_words(text, shutil.get_terminal_size().columns)
    typer.echo(text)


def follow(
    connection: EngineConnection, changed: threading.Event, first: OperatorCommand | None, *, rings: bool
) -> CalibrationView:
    """Write lines and take keys until the campaign has ended or nobody can take it further; return that view."""
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

"""The engine as a process, served on its socket until stdin is closed."""

import os
import threading
from contextlib import closing
from pathlib import Path

from fixtures_db.database import Database, open_db
from fixtures_db.errors import DatabaseError
from station.exit_codes import exit_code
from station.guide.engine import CalibrationEngine, prefetch
from station.guide.held_up import HeldUpWatch
from station.guide.server import ViewServer
from station.guide.start_engine import EngineOptions
from station.guide.view import CalibrationView

IDLE_S = 0.1
DRAWN_S = 1.0  # what a screen may take to draw its first view before anything else asks for the processor


def serve(path: Path, options: EngineOptions) -> None:
    """Serve one engine until stdin is closed; a database that cannot be opened is a view that says so."""
    stop = threading.Event()
    threading.Thread(target=_watch_stdin, args=(stop,), daemon=True).start()
    with ViewServer(path) as server:
        try:
            database = open_db(options.database)
        except DatabaseError as error:
            server.publish(CalibrationView(stage="failed", error=str(error), code=exit_code(error) or 0))
            stop.wait()
            return
        with database:
            _serve(server, database, options, stop)


def _serve(server: ViewServer, database: Database, options: EngineOptions, stop: threading.Event) -> None:
    engine = CalibrationEngine(database, options.engine(), server.publish)
    operator = None
    if options.first is None:
        server.publish(engine.view)
        threading.Thread(target=_prefetch, args=(stop,), daemon=True).start()
    with HeldUpWatch(lambda: server.view, server.publish) as watch, closing(engine):
        if options.first is not None:
            engine.obey(options.first)
        while not stop.is_set():
            for command in server.commands(0.0 if engine.is_busy else IDLE_S):
                engine.obey(command)
            with watch.round():
                engine.round()
            server.publish(engine.view)
            if engine.is_busy and (operator := operator or options.operator()):
                engine.watched_by(operator)


def _prefetch(stop: threading.Event) -> None:
    if not stop.wait(DRAWN_S):
        prefetch()


def _watch_stdin(stop: threading.Event) -> None:
    while os.read(0, 4096):
        pass
    stop.set()

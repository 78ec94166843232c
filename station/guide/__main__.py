"""The engine as a process: ``python -m station.guide SOCKET``, options as JSON on stdin, until stdin is closed."""

import json
import os
import sys
import threading
from pathlib import Path

from fixtures_db.database import Database, open_db
from fixtures_db.errors import DatabaseError
from station.exit_codes import exit_code
from station.guide.engine import Engine
from station.guide.operator import HandsLost
from station.guide.process import EngineOptions
from station.guide.server import Server
from station.guide.view import View

IDLE_S = 0.1


def main(path: Path, options: EngineOptions) -> None:
    """Serve one engine until stdin is closed; a database that cannot be opened is a view that says so."""
    stop = threading.Event()
    threading.Thread(target=_watch_stdin, args=(stop,), daemon=True).start()
    with Server(path) as server:
        try:
            database = open_db(options.database)
        except DatabaseError as error:
            server.publish(View(stage="failed", error=str(error), code=exit_code(error) or 0))
            stop.wait()
            return
        with database:
            _serve(server, database, options, stop)


def _serve(server: Server, database: Database, options: EngineOptions, stop: threading.Event) -> None:
    engine = Engine(database, options.engine(), server.publish)
    operator = options.operator()
    try:
        if options.first is not None:
            engine.obey(options.first)
        while not stop.is_set():
            for command in server.commands(0.0 if engine.is_busy else IDLE_S):
                engine.obey(command)
            engine.round()
            server.publish(engine.view)
            try:
                operator.look(engine.view)
            except HandsLost as error:
                engine.hands_lost(error)
    finally:
        engine.close()


def _watch_stdin(stop: threading.Event) -> None:
    while os.read(0, 4096):
        pass
    stop.set()


if __name__ == "__main__":
    main(Path(sys.argv[1]), EngineOptions.model_validate(json.loads(sys.stdin.readline())))

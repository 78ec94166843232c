"""The engine as a process: ``python -m station.guide SOCKET``, options as JSON on stdin, until stdin is closed."""

import json
import os
import sys
import threading
from pathlib import Path

from fixtures_db.database import open_db
from station.guide.engine import Engine
from station.guide.process import EngineOptions
from station.guide.server import Server

IDLE_S = 0.1


def main(path: Path, options: EngineOptions) -> None:
    """Serve one engine until stdin is closed."""
    stop = threading.Event()
    threading.Thread(target=_watch_stdin, args=(stop,), daemon=True).start()
    with open_db(options.database) as database, Server(path) as server:
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
                operator.look(engine.view)
        finally:
            engine.close()


def _watch_stdin(stop: threading.Event) -> None:
    while os.read(0, 4096):
        pass
    stop.set()


if __name__ == "__main__":
    main(Path(sys.argv[1]), EngineOptions.model_validate(json.loads(sys.stdin.readline())))

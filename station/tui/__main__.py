"""The screens of an engine that runs already: ``python -m station.tui SOCKET``, as a browser's tab does."""

import sys
from pathlib import Path

from station.guide.client import EngineConnection
from station.tui import run_screens

if __name__ == "__main__":
    with EngineConnection(Path(sys.argv[1])) as connection:
        run_screens(connection)

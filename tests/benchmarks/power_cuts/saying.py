"""What a workload says, a line of JSON, whenever something may be relied upon from then on.

``{"settled": 1}``: all before is on the disk. ``{"step": name, "file": ..., "sha256": ...}``: accepted.
``{"files": {path: sha256}}``: written whole. ``{"rows": {table: count}}``: stored.
"""

import hashlib
import json
import os
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

from station import cli

DATABASE, CAMPAIGN = "data/station.db", "campaigns/day"


def say(**what: Any) -> None:
    """Say what may be relied upon from now on."""
    os.write(1, (json.dumps(what) + "\n").encode())  # past a captured stdout


def sha256(path: Path) -> str:
    """Return a file's hash."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def station(*arguments: object) -> None:
    """Run a command; leave with what it says if it fails."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as said:
        code = cli.run([str(one) for one in arguments])
    if code:
        raise SystemExit(f"station {arguments[0]}: exit code {code}, {said.getvalue()}")


def written(*paths: Path) -> None:
    """Say that files are written whole."""
    say(files={path.name: sha256(path) for path in paths})

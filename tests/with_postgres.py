"""Run a command with a temporary PostgreSQL server: `python -m tests.with_postgres [--require] COMMAND ...`.

The server is the distribution's, listens on a Unix socket alone and dies with the command; its URL is in
STATION_TEST_POSTGRES. Without the binaries the command runs without a server, with ``--require`` it fails.
"""

import os
import pwd
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

URL = "STATION_TEST_POSTGRES"


def binary(name: str) -> Path | None:
    """Return where a program of the server is: on the PATH, or where Debian keeps it."""
    found = shutil.which(name)
    return Path(found) if found else max(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"), default=None)


def account() -> Mapping[str, Any]:
    """Return the account the server runs as: not root, which it refuses."""
    if os.geteuid() != 0:
        return {}
    nobody = pwd.getpwnam("nobody")
    return {"user": nobody.pw_uid, "group": nobody.pw_gid, "extra_groups": []}


@contextmanager
def server() -> Iterator[str | None]:
    """Yield the URL of a new server, None where there are no binaries."""
    programs = {name: binary(name) for name in ("initdb", "pg_ctl")}
    if not all(programs.values()):
        yield None
        return
    home = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))  # short: a socket's path has at most 107 bytes
    who = account()
    if who:
        os.chown(home, who["user"], who["group"])

    def call(name: str, *options: str) -> None:
        command = [str(programs[name]), "-D", str(home / "data"), *options]
        with (home / "log").open("ab") as log:
            if subprocess.run(command, stdout=log, stderr=log, timeout=600, cwd=home, **who).returncode:
                raise SystemExit(f"{name} failed:\n{(home / 'log').read_text()}")

    try:
        call("initdb", "--username=station", "--auth=trust", "--no-locale", "--encoding=UTF8", "--no-sync")
        call("pg_ctl", "--wait", "--options", f"-k {home} -c listen_addresses='' -c fsync=off", "start")
        try:
            yield f"postgresql://station@/postgres?host={home}"
        finally:
            call("pg_ctl", "--wait", "--mode=immediate", "stop")
    finally:
        shutil.rmtree(home)


def main(arguments: list[str]) -> int:
    """Run a command with the server; return its exit code."""
    must = arguments[:1] == ["--require"]
    command = arguments[must:]
    if os.environ.get(URL):
        return subprocess.run(command, check=False).returncode
    with server() as url:
        if url is None and must:
            raise SystemExit("no initdb and pg_ctl found, expected those of the distribution; install postgresql")
        added = {} if url is None else {URL: url}
        return subprocess.run(command, env=os.environ | added, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

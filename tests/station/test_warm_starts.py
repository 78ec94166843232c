"""A program that is forked is what it would be if it had been begun from nothing."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests import warm_starts
from tests.warm_starts import STATION

SAYS = """
import os, sys
print(sys.argv[1:], os.getcwd(), sorted(os.environ), os.getsid(0) == os.getpid())
print(sys.stdin.read(), "matplotlib" in sys.modules)
print("beside", file=sys.stderr)
"""
ENDS = {
    "pass": 0,
    "raise SystemExit(7)": 7,
    "raise SystemExit('in words')": 1,
    "raise ValueError('a bug')": 1,
    "import os; os._exit(9)": 9,
    "import atexit; atexit.register(print, 'at last')": 0,
    "import threading; threading.Timer(0.05, print, ['late']).start()": 0,
    "import os; os.kill(os.getpid(), 9)": -9,
    "raise KeyboardInterrupt": -signal.SIGINT,
    "import os, signal; os.kill(os.getpid(), signal.SIGTERM)": -signal.SIGTERM,
}
STARTS_ANOTHER = """
import os, subprocess, sys
subprocess.Popen._execute_child.__globals__["is_known"] = lambda command: True
code = "import os, sys; print(os.getppid(), 'matplotlib' in sys.modules)"
other = subprocess.Popen([sys.executable, "-P", "-c", code], stdout=subprocess.PIPE, text=True)
print(other.communicate()[0].split() == [str(os.getpid()), "True"], other.returncode)
"""


@pytest.fixture
def any_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything that is begun as a program is may be forked."""
    monkeypatch.setattr(warm_starts, "is_known", lambda command: command[1:3] == ["-P", "-c"])


def both(code: str, monkeypatch: pytest.MonkeyPatch, **how: object) -> list[tuple[int, str, list[str]]]:
    """Return exit code and what was said, forked and begun from nothing."""
    found = []
    for kind in (warm_starts.WarmPopen, warm_starts.FRESH):
        monkeypatch.setattr(subprocess, "Popen", kind)
        command = [sys.executable, "-P", "-c", code, "a", "b"]
        done = subprocess.run(command, capture_output=True, text=True, check=False, **how)  # type: ignore[call-overload]
        found.append((done.returncode, done.stdout, done.stderr.splitlines()[-1:]))
    return found


@pytest.mark.usefixtures("any_code")
@pytest.mark.parametrize("is_session", [False, True])
def test_arguments_folder_environment_session_and_pipes_are_its_own(
    is_session: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    environment = {"PATH": os.environ["PATH"], "ONLY": "this", "LC_ALL": "C.UTF-8"}
    forked, fresh = both(
        SAYS, monkeypatch, cwd=tmp_path, env=environment, input="typed", start_new_session=is_session
    )
    assert forked[1].endswith("typed True\n")
    assert fresh[1].endswith("typed False\n")
    assert forked[1].removesuffix("True\n") == fresh[1].removesuffix("False\n")
    assert forked[2] == fresh[2] == ["beside"]


@pytest.mark.usefixtures("any_code")
@pytest.mark.parametrize("code", ENDS)
def test_it_ends_as_it_would(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    forked, fresh = both(code, monkeypatch)
    assert forked == fresh
    assert forked[0] == ENDS[code]


@pytest.mark.usefixtures("any_code")
def test_what_it_starts_is_its_own_child_and_forked_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subprocess, "Popen", warm_starts.WarmPopen)
    command = [sys.executable, "-P", "-c", STARTS_ANOTHER]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "True 0\n"


def test_only_programs_of_the_station_are_forked() -> None:
    command = [sys.executable, "-P", "-c", "import sys; print('matplotlib' in sys.modules)"]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "False\n"
    station = [sys.executable, "-P", "-c", STATION, "--version"]
    assert subprocess.run(station, capture_output=True, text=True, check=True).stdout.startswith("station ")

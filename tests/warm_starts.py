"""Programs that tests start as processes of their own, forked from one that has imported what they import.

A fresh interpreter spends more than a second of processor time on imports before it is an engine. With
`warm_starts` a ``subprocess.Popen`` of one of `STARTS` is a process like any other - a child of whoever started
it, with its own pipes, environment, folder, session and exit code - that was forked, not begun from nothing; what
it starts itself, too. ``python -P warm_starts.py FD`` is the process that forks.
"""

import ctypes
import gc
import importlib
import inspect
import json
import os
import runpy
import socket
import subprocess
import sys
import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Lock
from typing import Any, NamedTuple

# A shell starts what it runs in the background deaf to Ctrl-C; so would be all that it starts.
DEAF_NO_MORE = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
STATION = f"{DEAF_NO_MORE}; from station.cli import main; main()"
STARTS = (
    ("-c", STATION),
    ("-m", "station.demo.device"),
    ("-m", "station.guide"),
    ("-m", "station.stream.reader"),
)
IMPORTED = (
    "drivers.simulated.server",
    "fixtures_db.migrations.upgrade",
    "matplotlib.backends.backend_svg",
    "station.cli",
    "station.demo.run",
    "station.files.campaign_folder.campaign_effects",
    "station.guide.engine_process",
    "station.guide.headless",
    "station.guide.live_campaign",
    "station.guide.outcome",
    "station.guide.readiness",
    "station.results.campaign_results",
    "station.results.diagnosis.closed_loop",
    "station.results.diagnosis.diagnosis_html",
    "station.results.report.report",
    "station.stream.gnss.sample_rate",
    "station.stream.reader.journal",
    "station.tui.app",
    "station.tui.web.server",
)
MESSAGE_BYTES = 1 << 18
PIPES = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
PR_SET_CHILD_SUBREAPER = 36
FRESH = subprocess.Popen


class Asked(NamedTuple):
    """A process to become: `sys.argv` after the interpreter's own options, and where it is."""

    arguments: list[str]
    environment: dict[str, str]
    folder: str
    is_session: bool


class Forks:
    """The way to a process that forks, a child of this one; it begins with the first start unless it is there."""

    def __init__(self, way: socket.socket | None = None) -> None:
        self._way, self._lock = way, Lock()
        self._process: subprocess.Popen[bytes] | None = None

    def start(self, asked: Asked, files: list[int]) -> int:
        """Return the number of a new child of this process that becomes what is asked for."""
        with self._lock:
            if self._way is None:
                self._way, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
                with theirs:
                    command = [sys.executable, "-P", __file__, str(theirs.fileno())]
                    self._process = FRESH(command, stdin=subprocess.DEVNULL, pass_fds=[theirs.fileno()])
            with _adopting():
                socket.send_fds(self._way, [json.dumps(asked).encode()], files)
                answer = self._way.recv(32)
        if not answer:
            raise ChildProcessError("the process that forks has ended")
        return int(answer)

    def close(self) -> None:
        """End the process that forks."""
        if self._way is not None:
            self._way.close()
        if self._process is not None:
            self._process.wait()


class WarmPopen(FRESH):  # type: ignore[type-arg]
    """`subprocess.Popen`, which forks what `STARTS` has."""

    forks = Forks()

    def _execute_child(self, args: Any, *rest: Any) -> None:
        given = inspect.signature(super()._execute_child).bind(args, *rest).arguments  # type: ignore[misc]
        plain = not any(given[each] for each in ("executable", "preexec_fn", "pass_fds", "shell"))
        if not (plain and is_known(args)):
            super()._execute_child(args, *rest)  # type: ignore[misc]
            return
        environment = dict(os.environ if given["env"] is None else given["env"])
        folder = os.path.abspath(given["cwd"] or "")
        asked = Asked([str(each) for each in args[2:]], environment, folder, given["start_new_session"])
        theirs = [given[each] for each in ("p2cread", "c2pwrite", "errwrite")]
        files = [own if each == -1 else each for own, each in enumerate(theirs)]
        self.pid = self.forks.start(asked, files)
        self._child_created = True
        self._close_pipe_fds(*(given[each] for each in PIPES))


def is_known(command: object) -> bool:
    """Whether a command is one of `STARTS`."""
    return isinstance(command, list) and command[:2] == [sys.executable, "-P"] and tuple(command[2:4]) in STARTS


@contextmanager
def warm_starts() -> Iterator[None]:
    """Fork what `STARTS` has as long as the ``with`` lasts."""
    WarmPopen.forks = Forks()
    subprocess.Popen = WarmPopen  # type: ignore[misc]
    try:
        yield
    finally:
        subprocess.Popen = FRESH  # type: ignore[misc]
        WarmPopen.forks.close()


@contextmanager
def _adopting() -> Iterator[None]:
    """Become the parent of what is left by its own below this process."""
    control = ctypes.CDLL(None).prctl
    control(PR_SET_CHILD_SUBREAPER, 1)
    try:
        yield
    finally:
        control(PR_SET_CHILD_SUBREAPER, 0)


def forked(way: socket.socket) -> tuple[Asked, list[int]]:
    """Fork for whoever asks by ``way``; return, in each child, what it is to become, and its three files."""
    while True:
        message, files, *_ = socket.recv_fds(way, MESSAGE_BYTES, 3)
        if not message:
            os._exit(0)
        told, tell = os.pipe()
        wait, go = os.pipe()
        if not (between := os.fork()):  # its end leaves the child to whoever asked
            if child := os.fork():
                os.write(tell, str(child).encode())
                os._exit(0)
            for each in (told, tell, go):
                os.close(each)
            os.read(wait, 1)
            os.close(wait)
            way.close()
            return Asked(*json.loads(message)), files
        os.waitpid(between, 0)
        way.send(os.read(told, 32))
        for each in (told, tell, wait, go, *files):
            os.close(each)


def become(way: socket.socket) -> Callable[[], object]:
    """Return, in each child, its program; a child can start others by a process that forks for it."""
    while True:
        asked, files = forked(way)
        if asked.is_session:
            os.setsid()
        ours, way = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        if os.fork():
            way.close()
            break
        ours.close()
        for each in files:
            os.close(each)
    WarmPopen.forks = Forks(ours)
    subprocess.Popen = WarmPopen  # type: ignore[misc]
    for own, each in enumerate(files):
        os.dup2(each, own)
        os.close(each)
    sys.stdin = open(0, closefd=False)
    sys.stdout = open(1, "w", buffering=1 if os.isatty(1) else -1, closefd=False)
    sys.stderr = open(2, "w", buffering=1, errors="backslashreplace", closefd=False)
    os.environ.clear()
    os.environ.update(asked.environment)
    os.chdir(asked.folder)
    return program(asked.arguments)


def program(arguments: list[str]) -> Callable[[], object]:
    """Return what ``python ARGUMENTS`` runs."""
    how, what, *rest = arguments
    sys.argv = [how, *rest]
    if how == "-m":
        return lambda: runpy.run_module(what, run_name="__main__", alter_sys=True)
    sys.modules["__main__"] = main = types.ModuleType("__main__")
    return lambda: exec(compile(what, "<string>", "exec"), main.__dict__)


if __name__ == "__main__":
    for each in IMPORTED:
        with suppress(ImportError):  # whoever needs it will say so
            importlib.import_module(each)
    gc.collect()
    gc.freeze()
    become(socket.socket(fileno=int(sys.argv[1])))()

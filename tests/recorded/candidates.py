"""Which of the calls kept by `tests.recorded.watched` can be stored, and the lines that each reaches."""

import dis
import inspect
import json
import os
import pickle
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from types import CodeType, FrameType
from typing import Any, TypeVar

from tests.paths import ROOT
from tests.recorded.folders import HERE
from tests.recorded.parts import text_of
from tests.recorded.replay import function, outcome, told_by
from tests.recorded.smaller import rounded, smaller
from tests.recorded.stored_values import Encoder
from tests.recorded.watched import KEPT

MOST_TEXT, MOST_S = 150_000, 0.5  # of a call
PER_MS = 40  # characters that a millisecond is worth
LOOKED_AT, OFTEN, OF_FUNCTION_S = 40, 3, 0.4  # calls of a function that are tried; of a line; for how long
AGAIN = 5  # calls of the same steps
AT_ALL = 60  # characters that any call costs
OURS = f"{gettempdir()}/tmp"  # begin of the folders that calls are replayed in
FORBIDDEN = (
    "socket.", "subprocess.", "os.system", "os.fork", "os.posix_spawn", "os.kill", "os.exec", "pty.", "signal.",
    "_thread.start_new_thread", "urllib.", "webbrowser.",
)  # fmt: skip
WRITES = (
    "os.remove",
    "os.rename",
    "os.rmdir",
    "os.mkdir",
    "os.truncate",
    "os.utime",
    "os.chmod",
    "os.symlink",
    "os.link",
    "sqlite3.connect",
)


LIMITS = {(signal.ITIMER_PROF, signal.SIGPROF): 1.0, (signal.ITIMER_REAL, signal.SIGALRM): 6.0}

T = TypeVar("T")
Step = tuple[int, int, int]  # function, condition in it or -1, and where it goes to: a line, or an instruction


@dataclass(frozen=True)
class Candidate:
    """A call that may be stored: its text, the parts of it, and the lines and ways that it goes in its module."""

    module: str
    name: str
    text: str
    parts: tuple[str, ...]
    cost: float
    steps: frozenset[Step]


class Guard:
    """Whether a call has opened, started or changed something outside of its folder."""

    def __init__(self) -> None:
        self.broken = ""
        self.on = False
        sys.addaudithook(self.heard)

    def heard(self, event: str, told: tuple[Any, ...]) -> None:
        if not self.on:
            return
        if event.startswith(FORBIDDEN):
            self.broken = event
        elif event == "open" and isinstance(told[0], str | os.PathLike):
            where = os.path.abspath(told[0])
            writes = isinstance(told[2], int) and told[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            ours = where.startswith((OURS, "/dev/null"))
            readable = (str(ROOT), sys.prefix, sys.base_prefix, "/usr/lib", "/usr/share")
            if not ours and (writes or not where.startswith(readable)):
                self.broken = f"{event} {where}"
        elif event in WRITES and not str(told[0]).startswith((OURS, ":memory:")):
            if event not in {"os.remove", "os.rmdir"} or told[1] == -1:  # else as a folder of ours is removed
                self.broken = event


def traced(module: str, call: Callable[[], T]) -> tuple[T, frozenset[Step]]:
    """Return what a call gives, the lines of its module that it reaches, and its way at each condition."""
    file = str(ROOT / module)
    steps, last = set[Step](), dict[int, int]()

    def step(frame: FrameType, event: str, _: object) -> Any:
        code, at = frame.f_code, frame.f_lasti
        if event == "line":
            steps.add((code.co_firstlineno, -1, frame.f_lineno))
        elif event == "opcode":
            before = last.get(id(frame), -1)
            if before in conditions(code):
                steps.add((code.co_firstlineno, before, at))
            last[id(frame)] = at
        return step

    def called(frame: FrameType, event: str, _: object) -> Any:
        if frame.f_code.co_filename != file:
            return None
        last.pop(id(frame), None)
        frame.f_trace_opcodes = True
        return step

    sys.settrace(called)
    try:
        found = call()
    finally:
        sys.settrace(None)
    return found, frozenset(steps)


@cache
def conditions(code: CodeType) -> frozenset[int]:
    """Return where a function's code jumps on a condition."""
    return frozenset(
        each.offset for each in dis.get_instructions(code) if "_IF_" in each.opname or each.opname == "FOR_ITER"
    )


REFUSED = list[str]()


class TooLong(BaseException):
    """A call takes longer than may be."""


def too_long(*_: object) -> None:
    raise TooLong


def limit(seconds: float) -> None:
    """End a call after so much processor time, or as it waits, on a machine however busy; none with 0."""
    for (timer, told), times in LIMITS.items():
        signal.signal(told, too_long)
        signal.setitimer(timer, times * seconds)


def candidates_of(module: str, name: str, guard: Guard) -> Iterator[Candidate]:
    """Yield the calls of a function that can be stored, made smaller, and made again with the same result."""
    end = time.process_time() + 2 * OF_FUNCTION_S
    for file in reaching(module, name, guard):
        if time.process_time() > end:
            break
        limit(8.0)
        try:
            yield from of_call(module, name, arguments_of(module, name, file), guard)
        except (TooLong, Exception) as error:
            REFUSED.append(f"{module}:{name}: {type(error).__name__} {str(error)[:100]}")
        finally:
            limit(0.0)


def reaching(module: str, name: str, guard: Guard) -> list[Path]:
    """Return those of the calls kept of a function that go other ways than others, the smallest first."""
    files = sorted((KEPT / module / name).glob("*.pickle"), key=lambda each: (each.stat().st_size, each.name))
    half, end = LOOKED_AT // 2, time.process_time() + OF_FUNCTION_S
    some = files[:half] + files[half :: max(1, -(-len(files) // half))]  # the smallest, which others take, too
    called, reached, found = function(module, name), Counter[Step](), list[Path]()
    for file in dict.fromkeys(some):
        if time.process_time() > end:
            break
        limit(4.0)
        guard.broken, guard.on = "", True
        try:
            with TemporaryDirectory() as folder:
                HERE[0] = Path(folder)
                values = pickle.loads(file.read_bytes())
                _, steps = traced(module, lambda: told_by(called, values))  # noqa: B023  (called at once)
            if not guard.broken and any(reached[each] < OFTEN for each in steps):
                found.append(file)
                reached.update(steps)
        except (TooLong, Exception) as error:
            REFUSED.append(f"{module}:{name}: {type(error).__name__} {str(error)[:100]}")
        finally:
            limit(0.0)
            guard.on = False
    return found


def of_call(module: str, name: str, arguments: Any, guard: Guard) -> Iterator[Candidate]:
    """Yield a call with ever more rows, as far as each makes other steps; no smaller one may fail."""
    size, seen = len(text_of(arguments)), set[frozenset[Step]]()
    fails = has_raised(outcome(module, name, arguments))
    for each in [rounded(arguments), arguments] if fails else [*smaller(arguments, size), arguments]:
        text = text_of(each)
        if len(text) > MOST_TEXT:
            continue
        found = tried(module, name, json.loads(text), guard, fails=fails)
        if found and found.steps not in seen:
            seen.add(found.steps)
            yield found


def tried(module: str, name: str, arguments: Any, guard: Guard, *, fails: bool) -> Candidate | None:
    """Return a call as a candidate, if it is quick, gives the same again, and leaves all else alone."""
    guard.broken, guard.on = "", True
    try:
        first, steps = traced(module, lambda: outcome(module, name, arguments))
        if has_raised(first) != fails:
            return None
        begin = time.process_time()
        second = outcome(module, name, arguments)
        seconds = time.process_time() - begin
        refused = guard.broken or ("it differs" if first != second else "it is slow" if seconds > MOST_S else "")
        if not refused:
            return Candidate(module, name, text_of(arguments), (), AT_ALL + PER_MS * seconds * 1e3, steps)
    finally:
        guard.on = False
    REFUSED.append(f"{module}:{name}: {refused}")
    return None


def arguments_of(module: str, name: str, file: Path) -> Any:
    """Return kept arguments as JSON, without those that are the defaults."""
    with TemporaryDirectory() as folder:
        HERE[0] = Path(folder)
        values = pickle.loads(file.read_bytes())
        asked = inspect.signature(function(module, name)).parameters
        if not any(each.kind is each.VAR_POSITIONAL for each in asked.values()):
            plain = bool | int | float | str | tuple | None
            values = {
                key: each
                for key, each in values.items()
                if not (
                    isinstance(each, plain)
                    and type(each) is type(asked[key].default)
                    and each == asked[key].default
                )
            }
        return Encoder().of(values)


def has_raised(columns: dict[str, Any]) -> bool:
    return any(path.startswith(".d.raises") for path in columns)


def of_module(module: str) -> list[Candidate]:
    """Return the calls of a module that may be stored; each function's are tried in a fork, which may die."""
    import_module(module.removesuffix(".py").replace("/", "."))
    candidates = list[Candidate]()
    for folder in sorted((KEPT / module).iterdir()):
        ours, theirs = os.pipe()
        if not (child := os.fork()):
            os.close(ours)
            with os.fdopen(theirs, "wb") as file:
                REFUSED.clear()
                os.chdir(gettempdir())  # where a file without a folder does no harm
                try:
                    pickle.dump((list(candidates_of(module, folder.name, Guard())), REFUSED), file)
                    file.flush()
                finally:
                    os._exit(0)
        os.close(theirs)
        with os.fdopen(ours, "rb") as file:
            got = file.read()
        os.waitpid(child, 0)
        more, refused = pickle.loads(got) if got else ([], [f"{module}:{folder.name}: the process died"])
        candidates += alike_left_out(more)
        REFUSED.extend(refused)
    return candidates


def alike_left_out(candidates: list[Candidate]) -> list[Candidate]:
    """Return candidates without those that make the same steps as several smaller ones."""
    count, found = Counter[frozenset[Step]](), list[Candidate]()
    for each in sorted(candidates, key=lambda each: each.cost + len(each.text)):
        count[each.steps] += 1
        if count[each.steps] <= AGAIN:
            found.append(each)
    return found

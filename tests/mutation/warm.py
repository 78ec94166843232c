"""A process that has collected every test; for each run of some of them it forks a child.

``python -P warm.py TREE TESTS...`` answers each line of JSON with another: it runs tests (files, or single ones)
until one fails, with a function's mutant in the place of the function, or traced: which functions they call.
"""

import gc
import json
import math
import os
import resource
import select
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, field
from itertools import groupby
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any, TextIO

import pytest

UNFIT, CRASH, TIMEOUT = "unfit", "crash", "timeout"  # cannot be replaced; the process died; it went on
SLOWED = 10.0  # so much longer than its processor time a test takes at most, if it does not wait
COLLECT_S = 150.0  # of processor time, of importing the tests
MOST_BYTES = 8 * 2**30  # of memory: what fills a queue for ever would take all that others have
WAITS = 6  # of its limit of processor time a run may take of time: a machine is shared, and some tests wait


class Forks:
    """Instead of running the tests collected, fork for each line of ``commands``."""

    def __init__(self, root: Path, commands: TextIO, answers: TextIO) -> None:
        self.root, self.commands, self.answers = root, commands, answers
        self.failed, self.functions = "", dict[tuple[str, str], list[FunctionType]]()
        self.as_imported = Calls(root)
        self.as_imported.begin()

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.as_imported.end("")
        items: dict[str, list[pytest.Item]] = {}
        for each in session.items:
            for name in {each.nodeid, each.nodeid.split("::")[0]}:
                items.setdefault(name, []).append(each)
        gc.unfreeze()  # `tests/conftest.py` freezes what is collected, and frozen functions are not listed
        self.functions = functions_of(self.root)
        gc.freeze()  # what is collected here stays: a child's collector would else touch, and so copy, all of it
        told = {"failed": self.failed, "as_imported": [*self.as_imported.found]}
        print(json.dumps(told), file=self.answers, flush=True)
        self.failed = ""
        for line in self.commands:
            asked = json.loads(line)
            chosen = dict.fromkeys(each for test in asked["tests"] for each in items.get(test, ()))
            left = [each for each in chosen if each.nodeid not in asked["left_out"]]
            print(self._forked(left, asked), file=self.answers, flush=True)
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def _forked(self, items: list[pytest.Item], asked: dict[str, Any]) -> str:
        ours, theirs = os.pipe()
        if not (child := os.fork()):
            os.setsid()
            limit(asked["limit_s"])
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            answer = {"failed": CRASH}
            try:
                answer = self._run(items, asked)
            finally:
                os.write(theirs, json.dumps(answer).encode() + b"\n")
                os._exit(0)
        os.close(theirs)
        answered = select.select([ours], [], [], WAITS * asked["limit_s"])[0]
        with os.fdopen(ours) as file:
            answer = file.readline().strip() if answered else ""
        os.killpg(child, signal.SIGKILL)  # and what its tests have started
        _, status = os.waitpid(child, 0)
        is_late = not answered or os.waitstatus_to_exitcode(status) == -signal.SIGXCPU
        return answer or json.dumps({"failed": TIMEOUT if is_late else CRASH})

    def _run(self, items: list[pytest.Item], asked: dict[str, Any]) -> dict[str, Any]:
        if asked.get("function"):
            path, name = self.root / asked["file"], asked["function"]
            if not replaced(self.functions.get((str(path), name), []), path, name):
                return {"failed": UNFIT}
        calls, run = Calls(self.root), Run()
        for _, of_file in groupby(items, lambda each: each.nodeid.split("::")[0]):
            if not self._run_file([*of_file], asked, calls, run):
                break
        left = dict.fromkeys(each.nodeid.split("::")[0] for each in items if each.nodeid not in run.passed)
        return asdict(run) | {"calls": calls.found, "left": [*left]}

    def _run_file(self, items: list[pytest.Item], asked: dict[str, Any], calls: "Calls", run: "Run") -> bool:
        """Run tests of a file, for ``enough_s`` or until one fails; return whether the next file is to be run."""
        since, spent, enough = time.monotonic(), list[float](), asked.get("enough_s", math.inf)
        for item, after in zip(items, [*items[1:], None], strict=True):
            begin = sum(os.times()[:4])
            with calls.of(item.nodeid) if asked.get("trace") else nullcontext():
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
            spent.append(sum(os.times()[:4]) - begin)
            run.passed += [] if self.failed else [item.nodeid]
            run.failed, self.failed = run.failed or self.failed, ""
            if run.failed and not asked.get("trace"):
                return False
            if max(sum(spent), (time.monotonic() - since) / SLOWED) > enough:
                break
        run.seconds += sum(spent) + (len(items) - len(spent)) * min(spent)  # the first make what all need
        items[0].session._setupstate.teardown_exact(None)  # noqa: SLF001
        return run.seconds < asked.get("most_s", math.inf)


@dataclass
class Run:
    """What a run of tests has shown."""

    failed: str = ""
    seconds: float = 0.0
    passed: list[str] = field(default_factory=list)


class Calls:
    """Which tests call each function of a tree: ``folder/file.py:Class.function``, inner ones by the outermost."""

    def __init__(self, root: Path) -> None:
        self.within, self.found, self.codes = f"{root}/", dict[str, list[str]](), dict[int, CodeType]()

    @contextmanager
    def of(self, test: str) -> Iterator[None]:
        self.begin()
        yield
        self.end(test)

    def begin(self) -> None:
        codes: dict[int, CodeType] = {}

        def traced(frame: FrameType, event: str, argument: object) -> None:
            codes.setdefault(id(frame.f_code), frame.f_code)

        self.codes = codes
        threading.settrace(traced)
        sys.settrace(traced)

    def end(self, test: str) -> None:
        sys.settrace(None)
        threading.settrace(None)
        called = [*self.codes.values()]
        for file, name in {(each.co_filename, each.co_qualname.split(".<locals>")[0]) for each in called}:
            if file.startswith(self.within):
                self.found.setdefault(f"{file.removeprefix(self.within)}:{name}", []).append(test)


def functions_of(root: Path) -> dict[tuple[str, str], list[FunctionType]]:
    """Return the functions of the tree by their file and name."""
    found: dict[tuple[str, str], list[FunctionType]] = {}
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename.startswith(f"{root}/"):
            found.setdefault((each.__code__.co_filename, each.__code__.co_qualname), []).append(each)
    return found


def replaced(functions: Sequence[FunctionType], path: Path, name: str, source: str | None = None) -> bool:
    """Give the functions of this name the code of ``source``, or of the file as it is; False if that fails."""
    text = path.read_bytes() if source is None else source
    waiting, codes = [compile(text, str(path), "exec")], list[CodeType]()
    while waiting:
        code = waiting.pop()
        inner = [each for each in code.co_consts if isinstance(each, CodeType)]
        codes += [each for each in inner if each.co_qualname == name]
        waiting += [each for each in inner if ".<locals>" not in each.co_qualname]
    if len(codes) != 1 or not functions:
        return False
    try:
        for each in functions:
            each.__code__ = codes[0]
    except ValueError:  # it closes over other variables
        return False
    return True


def limit(seconds: float) -> None:
    """End this process once it has taken so much processor time, or memory: time alone tells a loaded machine."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(seconds), resource.RLIM_INFINITY))


if __name__ == "__main__":
    commands, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(null, number)
    root = Path(sys.argv[1])
    limit(COLLECT_S)
    plain = ["-q", "-s", "-n", "0", "-p", "no:cacheprovider", "--continue-on-collection-errors"]
    sys.exit(pytest.main([*plain, *sys.argv[2:]], plugins=[Forks(root, commands, answers)]))

"""A process that has collected every test; for each run of some of them it forks a child.

``python -P warm.py TREE TESTS...`` answers each line of JSON with another: it runs tests (files, or single ones)
until one fails, with a function's mutant in the place of the function, or traced: which functions they call.
"""

import gc
import json
import math
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any, TextIO

import pytest

UNFIT, CRASH = "unfit", "crash"  # the function cannot be replaced; the process died


class Forks:
    """Instead of running the tests collected, fork for each line of ``commands``."""

    def __init__(self, root: Path, commands: TextIO, answers: TextIO) -> None:
        self.root, self.commands, self.answers = root, commands, answers
        self.failed, self.functions = "", dict[tuple[str, str], list[FunctionType]]()

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        items: dict[str, list[pytest.Item]] = {}
        for each in session.items:
            for name in {each.nodeid, each.nodeid.split("::")[0]}:
                items.setdefault(name, []).append(each)
        gc.unfreeze()  # `tests/conftest.py` freezes what is collected, and frozen functions are not listed
        self.functions = functions_of(self.root)
        gc.freeze()  # what is collected here stays: a child's collector would else touch, and so copy, all of it
        print(json.dumps({"failed": self.failed}), file=self.answers, flush=True)
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
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            answer = {"failed": CRASH}
            try:
                answer = self._run(items, asked)
            finally:
                os.write(theirs, json.dumps(answer).encode() + b"\n")
                os._exit(0)
        os.close(theirs)
        answered = select.select([ours], [], [], asked["limit_s"])[0]
        with os.fdopen(ours) as file:
            answer = (file.readline() or json.dumps({"failed": CRASH})) if answered else ""
        os.killpg(child, signal.SIGKILL)  # and what its tests have started
        os.waitpid(child, 0)
        return answer.strip() or json.dumps({"failed": "timeout"})

    def _run(self, items: list[pytest.Item], asked: dict[str, Any]) -> dict[str, Any]:
        if asked.get("function"):
            path, name = self.root / asked["file"], asked["function"]
            if not replaced(self.functions.get((str(path), name), []), path, name):
                return {"failed": UNFIT}
        calls, spent, passed, failed = Calls(self.root), list[float](), list[str](), ""
        since = time.monotonic()
        for item, after in zip(items, [*items[1:], None], strict=False):
            begin = sum(os.times()[:4])
            with calls.of(item.nodeid) if asked.get("trace") else nullcontext():
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
            spent.append(sum(os.times()[:4]) - begin)
            passed += [] if self.failed else [item.nodeid]
            shown = max(sum(spent), (time.monotonic() - since) / 5)
            if shown > asked.get("enough_s", math.inf) or (self.failed and not asked.get("trace")):
                break
            failed, self.failed = failed or self.failed, ""
        seconds = sum(spent) + (len(items) - len(spent)) * min(spent, default=0.0)  # the first make what all need
        return {"failed": failed or self.failed, "seconds": seconds, "calls": calls.found, "passed": passed}


class Calls:
    """Which tests call each function of a tree: ``folder/file.py:Class.function``, inner ones by the outermost."""

    def __init__(self, root: Path) -> None:
        self.within, self.found = f"{root}/", dict[str, list[str]]()

    @contextmanager
    def of(self, test: str) -> Iterator[None]:
        codes: dict[int, CodeType] = {}

        def traced(frame: FrameType, event: str, argument: object) -> None:
            codes.setdefault(id(frame.f_code), frame.f_code)

        threading.settrace(traced)
        sys.settrace(traced)
        yield
        sys.settrace(None)
        for file, name in {
            (each.co_filename, each.co_qualname.split(".<locals>")[0]) for each in [*codes.values()]
        }:
            if file.startswith(self.within):
                self.found.setdefault(f"{file.removeprefix(self.within)}:{name}", []).append(test)


def functions_of(root: Path) -> dict[tuple[str, str], list[FunctionType]]:
    """Return the functions of the tree by their file and name."""
    found: dict[tuple[str, str], list[FunctionType]] = {}
    for each in gc.get_objects():
        if isinstance(each, FunctionType) and each.__code__.co_filename.startswith(f"{root}/"):
            found.setdefault((each.__code__.co_filename, each.__code__.co_qualname), []).append(each)
    return found


def replaced(functions: list[FunctionType], path: Path, name: str) -> bool:
    """Give the functions of this name the code that stands in the file now; False if that is not possible."""
    waiting, codes = [compile(path.read_bytes(), str(path), "exec")], list[CodeType]()
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


if __name__ == "__main__":
    commands, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(null, number)
    root = Path(sys.argv[1])
    plain = ["-q", "-s", "-n", "0", "-p", "no:cacheprovider", "--continue-on-collection-errors"]
    sys.exit(pytest.main([*plain, *sys.argv[2:]], plugins=[Forks(root, commands, answers)]))

"""Keep arguments of calls while tests run: ``pytest -p tests.recorded.watched``; see `docs/station-tests.md`.

At the begin of each function and method of the modules that mutants are drawn from a line is put that hands its
arguments on: modules are changed as they are imported, in memory. A few calls of each function and file of tests
are kept as pickles, which `tests.recorded.choice` chooses from. Nothing is kept of programs that the tests start.
"""

import ast
import hashlib
import importlib.machinery
import io
import os
import pickle
from collections.abc import Iterator
from pathlib import Path, PosixPath
from types import CodeType
from typing import Any

import pytest

from tests.paths import ROOT
from tests.recorded.folders import reduced_path
from tests.recorded.named_objects import name_of, named
from tests.recorded.stored_modules import LEFT_OUT

KEPT = ROOT / "build/recorded/calls"
MOST_BYTES, LARGE = 600_000, 30_000  # of the arguments of a call; of those that are fewer kept
OF_FILE, OF_ALL = 8, 150  # calls of a function that are kept of a file of tests; of all, beyond which it is one
FEW_TESTS = 50  # of a run, up to which each test counts as a file does
TRIED, MOST_FAILED = 30, 60  # calls looked at, of a file; those that cannot be kept until it is given up
KERNELS = {"kernel", "inlined", "njit"}  # compiled, and so not seen, but by NUMBA_DISABLE_JIT=1

Function = tuple[str, str, tuple[str, ...]]  # its module, name in it, and arguments


class Small(io.RawIOBase):
    """What is written, up to a limit."""

    def __init__(self) -> None:
        self.parts, self.size = list[bytes](), 0

    def write(self, part: Any) -> int:
        self.size += len(part)
        if self.size > MOST_BYTES:
            raise OverflowError
        self.parts.append(bytes(part))
        return len(part)


class Pickler(pickle.Pickler):
    """Paths go with what they lead to; what a module holds is its name."""

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, PosixPath):
            return reduced_path(value)
        held = name_of(value)
        return (named, held) if held else NotImplemented


class Watch:
    """The functions watched: whether one is looked at now, and what has been kept of it."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.functions = folder, list[Function]()
        self.on, self.next, self.calls = list[bool](), list[int](), list[int]()
        self.of_file, self.tried, self.kept, self.failed = list[int](), list[int](), list[int](), list[int]()
        self.busy = False

    def add(self, function: Function) -> int:
        self.functions.append(function)
        self.on.append(True)
        for each in (self.next, self.calls, self.of_file, self.tried, self.kept, self.failed):
            each.append(0)
        return len(self.functions) - 1

    def begin_file(self) -> None:
        for i, failed in enumerate(self.failed):
            self.on[i], self.next[i], self.calls[i] = failed < MOST_FAILED, 0, 0
            self.of_file[i] = self.tried[i] = 0

    def seen(self, i: int, found: dict[str, Any]) -> None:
        """Keep the arguments of a call, if it is one of those looked at: the first, then ever fewer."""
        self.calls[i] += 1
        if self.calls[i] <= self.next[i] or self.busy:
            return
        self.next[i] = self.calls[i] * 3 // 2 if self.calls[i] > 3 else self.calls[i]
        self.tried[i] += 1
        self.busy = True
        try:
            self._keep(i, {name: found[name] for name in self.functions[i][2]})
        except Exception:
            self.failed[i] += 1
        finally:
            self.busy = False
        most = OF_FILE if self.kept[i] < OF_ALL else 1
        self.on[i] = self.of_file[i] < most and self.tried[i] < TRIED and self.failed[i] < MOST_FAILED

    def _keep(self, i: int, arguments: dict[str, Any]) -> None:
        small = Small()
        Pickler(small, 4).dump(arguments)
        whole = b"".join(small.parts)
        module, name, _ = self.functions[i]
        file = self.folder / module / name / f"{hashlib.sha256(whole).hexdigest()[:16]}.pickle"
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            new = file.with_suffix(f".{os.getpid()}")
            new.write_bytes(whole)
            new.rename(file)
            self.of_file[i] += 1 if len(whole) < LARGE else 4
            self.kept[i] += 1


WATCH = Watch(KEPT)


def functions(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield the functions and methods of a module, by their name in it; not those within functions."""
    waiting: list[tuple[str, ast.stmt]] = [("", each) for each in tree.body]
    while waiting:
        prefix, node = waiting.pop(0)
        if isinstance(node, ast.ClassDef):
            waiting += [(f"{prefix}{node.name}.", each) for each in node.body]
        elif isinstance(node, ast.FunctionDef):
            yield f"{prefix}{node.name}", node


def watched(source: bytes, path: str) -> CodeType:
    """Compile a module with a line at the begin of each function that hands its arguments on."""
    tree, module = ast.parse(source), str(Path(path).relative_to(ROOT))
    compiled = not os.environ.get("NUMBA_DISABLE_JIT")
    for name, node in functions(tree):
        marks = {each.id for each in node.decorator_list if isinstance(each, ast.Name)}
        if (compiled and marks & KERNELS) or "overload" in marks:
            continue
        asked = node.args
        several = [each for each in (asked.vararg, asked.kwarg) if each]
        names = [each.arg for each in (*asked.posonlyargs, *asked.args, *asked.kwonlyargs, *several)]
        i = WATCH.add((module, name, tuple(names)))
        line = ast.parse(f"if __watch__.on[{i}]: __watch__.seen({i}, locals())").body[0]
        first = 1 if ast.get_docstring(node, clean=False) is not None and len(node.body) > 1 else 0
        for each in ast.walk(line):
            ast.copy_location(each, node.body[first])
        node.body.insert(first, line)
    return compile(tree, path, "exec", dont_inherit=True)


PLAIN = importlib.machinery.SourceFileLoader.get_code


def get_code(loader: Any, name: str) -> Any:
    path = loader.get_filename(name)
    if not path.startswith(f"{ROOT}/") or not path[len(str(ROOT)) + 1 :].startswith(OF):
        return PLAIN(loader, name)
    if any(each in path for each in LEFT_OUT):
        return PLAIN(loader, name)
    return watched(loader.get_data(path), path)


OF = tuple(os.environ.get("WATCHED", "").split())
if OF:
    import builtins

    builtins.__watch__ = WATCH  # type: ignore[attr-defined]
    importlib.machinery.SourceFileLoader.get_code = get_code  # type: ignore[method-assign]


class Files:
    """Each file of tests keeps its own few calls; where there are few tests, each test does."""

    file, of_tests = "", False

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self.of_tests = len(session.items) < FEW_TESTS

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        if (file := nodeid if self.of_tests else nodeid.split("::")[0]) != self.file:
            self.file = file
            WATCH.begin_file()


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Files())

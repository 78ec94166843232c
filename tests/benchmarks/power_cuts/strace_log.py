"""The file operations of a real process, its threads and its children, by strace(1).

SQLite's own are among them, as it calls the system itself. Memory-mapped writes are not: SQLite maps its WAL index
(``-shm``) alone, which is made anew after a crash, whatever it holds.
"""

import ctypes
import os
import re
import subprocess
import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from tests.benchmarks.power_cuts.disk_models import ROOT, Entries, FileLog, Operation, Resize, Say, Sync, Write

CALLS = (
    "openat,open,creat,write,pwrite64,writev,pwritev,pwritev2,ftruncate,truncate,fallocate,fsync,fdatasync,"
    "sync_file_range,rename,renameat,renameat2,link,linkat,symlink,symlinkat,unlink,unlinkat,mkdir,mkdirat,rmdir,"
    "dup,dup2,dup3,lseek,clone,clone3,fork,vfork,copy_file_range,sendfile"
)
_BEGUN = re.compile(r"(\d+) +(\w+)\((.*) <unfinished \.\.\.>$")
_RESUMED = re.compile(r"(\d+) +<\.\.\. (\w+) resumed>(.*)\) += (-?\d+)")
_WHOLE = re.compile(r"(\d+) +(\w+)\((.*)\) += (-?\d+)")
HERE = "AT_FDCWD"
SET_PTRACER, ANYBODY = 0x59616D61, ctypes.c_ulong(-1)  # prctl(2): a sibling may trace us


def traced(do: Callable[[], None], log: Path) -> None:
    """Run ``do`` in a child, its calls noted in ``log``; raise `ChildProcessError` if it fails."""
    go, starter = os.pipe()
    child = os.fork()
    if not child:
        _run_when_started(go, do)
    how = ["strace", "-f", "-qq", "-xx", "-s", "1000000000", "-o", str(log), "-e", f"trace={CALLS}"]
    with subprocess.Popen([*how, "-p", str(child)]) as tracer:
        status = Path(f"/proc/{child}/status")
        while "TracerPid:\t0\n" in status.read_text() and tracer.poll() is None:
            time.sleep(0.005)
        os.write(starter, b"!")
        os.close(starter)
        os.close(go)
        _, status = os.waitpid(child, 0)
    if status or tracer.returncode:
        raise ChildProcessError(f"the child ended with {status}, strace with {tracer.returncode}")


def _run_when_started(go: int, do: Callable[[], None]) -> None:
    code = 1
    try:
        ctypes.CDLL(None).prctl(SET_PTRACER, ANYBODY, 0, 0, 0)
        os.read(go, 1)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        do()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


@dataclass(slots=True)
class _Opened:
    node: int
    at: int = 0
    appends: bool = False


@dataclass(slots=True)
class _Replay:
    """Calls made operations; a process is named by its first thread's number."""

    root: str
    operations: list[Operation] = field(default_factory=list)
    folders: dict[int, dict[str, int]] = field(default_factory=lambda: {ROOT: {}})
    sizes: dict[int, int] = field(default_factory=dict)
    opened: dict[int, dict[int, _Opened]] = field(default_factory=dict)

    def call(self, thread: int, name: str, given: list[str], result: int, began: int) -> None:
        """Take one call that succeeded."""
        files = self.opened.setdefault(thread, {})
        opened = files.get(int(given[0])) if given[0].isdigit() else None
        match name:
            case "openat" | "open" | "creat":
                where = given if name == "openat" else [HERE, *given]
                self._open(files, where, result, creates=name == "creat")
            case "write":
                self._write(opened, int(given[0]), _bytes(given[1])[:result])
            case "dup" | "dup2" | "dup3":
                files.pop(result, None)
                if opened:
                    files[result] = opened
            case "pwrite64" if opened:
                self._put(opened.node, int(given[3]), _bytes(given[1])[:result])
            case "lseek" if opened:
                opened.at = result
            case "ftruncate" if opened:
                self._resize(opened.node, int(given[1]))
            case "fsync" | "fdatasync" if opened:
                self.operations.append(Sync(opened.node, began))
            case "pwrite64" | "lseek" | "ftruncate" | "fsync" | "fdatasync":
                pass  # of a file elsewhere
            case "clone" | "clone3" | "fork" | "vfork":
                shares = "CLONE_FILES" in "".join(given)
                self.opened[result] = files if shares else dict(files)
            case _:
                self._named(files, name, given)

    def _named(self, files: dict[int, _Opened], name: str, given: list[str]) -> None:
        """Take a call that changes names."""
        if name in {"mkdir", "rmdir", "unlink"}:
            given = [HERE, *given]
        elif name in {"rename", "truncate"}:
            given = [HERE, given[0], HERE, *given[1:]]
        place = self._place(files, *given[:2]) if given[0] == HERE or given[0].isdigit() else None
        match name:
            case "mkdir" | "mkdirat" if place:
                node = self._new_node()
                self.folders[node] = {}
                self._set(((*place, node),))
            case "unlink" | "unlinkat" | "rmdir" if place:
                self._set(((*place, None),))
            case "rename" | "renameat" | "renameat2":
                target = self._place(files, *given[2:4])
                if place and target:
                    moved = self.folders[place[0]][place[1]]
                    self._set(((*place, None), (*target, moved)))
                elif place or target:
                    raise ValueError(f"a file renamed into or out of {self.root}")
            case _ if place or (given[0].isdigit() and int(given[0]) in files):
                raise ValueError(f"{name} on a file of {self.root} is not modelled")

    def _open(self, files: dict[int, _Opened], given: list[str], result: int, *, creates: bool) -> None:
        files.pop(result, None)
        flags = "O_TRUNC" if creates else given[2]
        if (place := self._place(files, *given[:2])) is None:
            return
        folder, name = place
        node = ROOT if not name else self.folders[folder].get(name)
        if node is None:
            node = self._new_node()
            self.sizes[node] = 0
            self._set(((folder, name, node),))
        elif "O_TRUNC" in flags and self.sizes[node]:
            self._resize(node, 0)
        files[result] = _Opened(node, appends="O_APPEND" in flags)

    def _write(self, opened: _Opened | None, number: int, data: bytes) -> None:
        if opened is None:
            if number == 1:
                self.operations.append(Say(data.decode("utf-8", "replace")))
            return
        if opened.appends:
            opened.at = self.sizes[opened.node]
        self._put(opened.node, opened.at, data)
        opened.at += len(data)

    def _put(self, node: int, offset: int, data: bytes) -> None:
        self.operations.append(Write(node, offset, data))
        self.sizes[node] = max(self.sizes[node], offset + len(data))

    def _resize(self, node: int, size: int) -> None:
        self.operations.append(Resize(node, size))
        self.sizes[node] = size

    def _set(self, changes: tuple[tuple[int, str, int | None], ...]) -> None:
        for folder, name, node in changes:
            if node is None:
                self.folders[folder].pop(name, None)
            else:
                self.folders[folder][name] = node
        self.operations.append(Entries(changes))

    def _new_node(self) -> int:
        return 1 + len(self.sizes) + len(self.folders) - 1

    def _place(self, files: dict[int, _Opened], at: str, path: str) -> tuple[int, str] | None:
        """Return folder and name of a path, None outside of the root; the root itself has no name."""
        where = os.fsdecode(_bytes(path))
        if at != HERE and not where.startswith("/"):
            if (opened := files.get(int(at))) is None:
                return None
            folder, parts = opened.node, [part for part in where.split("/") if part != "."]
        else:
            if where != self.root and not where.startswith(self.root + "/"):
                return None
            folder, parts = ROOT, where.removeprefix(self.root).strip("/").split("/")
        for part in parts[:-1]:
            folder = self.folders[folder][part]
        return folder, parts[-1]


def _bytes(text: str) -> bytes:
    if not text.startswith('"'):
        raise ValueError(f"found {text[:40]} in a trace, expected a string")
    return bytes.fromhex(text.strip('"').replace("\\x", ""))


def read_log(lines: Iterable[str], root: Path) -> FileLog:
    """Return what was done below ``root``, an absolute path; it is empty when the trace begins."""
    replay, pending = _Replay(str(root)), dict[int, tuple[str, int]]()
    for line in lines:
        if begun := _BEGUN.match(line):
            pending[int(begun[1])] = begun[3], len(replay.operations)
            continue
        if resumed := _RESUMED.match(line):
            thread, name, (first, began) = int(resumed[1]), resumed[2], pending.pop(int(resumed[1]))
            given, result = (first + resumed[3]), int(resumed[4])
        elif whole := _WHOLE.match(line):
            thread, name, given, result = int(whole[1]), whole[2], whole[3], int(whole[4])
            began = len(replay.operations)
        else:
            continue  # a signal, an exit
        if result >= 0:
            replay.call(thread, name, given.split(", "), result, began)
    return FileLog(tuple(replay.operations), frozenset(replay.folders))

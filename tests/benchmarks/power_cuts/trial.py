"""A workload recorded, its crash states drawn, each put on a disk in memory and checked."""

import re
import shutil
import sqlite3
import sys
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import partial
from pathlib import Path

from tests.benchmarks.power_cuts.crash_checks import CHECKS, Known, Wrong, read_reports
from tests.benchmarks.power_cuts.disk_models import MODELS, CrashState, FileLog, Say, crash_states
from tests.benchmarks.power_cuts.strace_log import read_log, traced
from tests.benchmarks.power_cuts.workloads import WORKLOADS
from tests.paths import disk_in_memory
from tests.proof.evidence import Figure, zero

DATA, MEMORY_MAPPED = "data/", "-shm"
MOST_ROUNDS = 1000
GOES_ON_EVERY = 20  # states until a campaign is gone on with, and read whole


def recorded(workload: str, scratch: Path) -> tuple[FileLog, Path]:
    """Run a workload under strace; return its log and its home, and check that the log tells all of it."""
    home, log = scratch / "home", scratch / "log"
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    traced(partial(WORKLOADS[workload], home), log)
    with log.open() as lines:
        found = read_log(lines, home)
    log.unlink()
    _compare(found, home)
    return found, home


def _compare(log: FileLog, home: Path) -> None:
    """Raise `ValueError` where the log's last state is not what stands on the disk."""
    last = None
    for state in crash_states(log, 0, 0):
        last = state if (state.model, state.kept) == ("weak", "all") else last
    assert last is not None
    there = {str(path.relative_to(home)): path for path in home.rglob("*")}
    if set(there) != set(last.files):
        raise ValueError(f"the trace differs from the disk in {sorted(set(there) ^ set(last.files))[:5]}")
    for name, content in last.files.items():
        if content is not None and not name.endswith(MEMORY_MAPPED) and there[name].read_bytes() != content:
            raise ValueError(f"the trace differs from the disk in the bytes of {name}")


def place(files: Mapping[str, bytes | None], home: Path) -> None:
    """Put a state into a folder in place of what is there."""
    shutil.rmtree(home)
    home.mkdir()
    for name in sorted(files):
        content, path = files[name], home / name
        if content is None:
            path.mkdir()
        else:
            path.write_bytes(content)


class Meaning:
    """Finds what states mean to whoever reads them: two states of one meaning need one check.

    A database means the rows that SQLite recovers from file and log, once for each of their contents. A file whose
    name begins with a dot is aside or a lock: it is taken away unread, so that its name alone counts.
    """

    def __init__(self, home: Path) -> None:
        self._folder = home.parent / "recovered"
        self._rows: dict[int, int] = {}

    def of(self, state: CrashState) -> int:
        """Return a hash of a state's meaning."""
        database = {name: one for name, one in state.files.items() if name.startswith(DATA) and one is not None}
        key = hash(frozenset(each for each in database.items() if not each[0].endswith(MEMORY_MAPPED)))
        if key not in self._rows:
            files = {name.removeprefix(DATA): one for name, one in database.items()}
            self._rows[key] = hash(tuple(self._recovered(files)))
        others = frozenset(
            (name, one is None, None if name.rpartition("/")[2].startswith(".") else one)
            for name, one in state.files.items() if name not in database
        )  # fmt: skip
        return hash((len(state.reported), others, self._rows[key]))

    def _recovered(self, files: dict[str, bytes]) -> Iterator[str]:
        """Yield all rows of a database, and what its own check says."""
        if "station.db" not in files:
            yield "no database" if files else "none"
            return
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir()
        for name, content in files.items():
            (self._folder / name).write_bytes(content)
        with closing(sqlite3.connect(self._folder / "station.db")) as connection:
            try:
                yield repr(connection.execute("PRAGMA integrity_check").fetchall())
                yield repr(connection.execute("SELECT name, sql FROM sqlite_master ORDER BY name").fetchall())
                tables = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
                for (name,) in sorted(tables):
                    yield repr(connection.execute(f"SELECT * FROM {name}").fetchall())
            except sqlite3.DatabaseError as error:
                yield repr(error)


def tried(workload: str, states: int, seed: int) -> "Trial":
    """Record a workload and check about ``states`` different states of it, from all of its length."""
    with disk_in_memory() as scratch:
        log, home = recorded(workload, scratch)
        trial = Trial(workload, home, log)
        least = len(MODELS) * 2 * trial.operations  # at each cut all kept, and none
        every, draws = max(1, least // states), max(1, 2 * states // least)
        for number in range(MOST_ROUNDS):
            before = trial.states
            for state in crash_states(log, seed + number, draws, every):
                trial.look(state)
            if trial.states >= states or trial.states - before < states // 100:
                break
    return trial


class Trial:
    """Checks states that were not seen before, each meaning once, and counts what came of it."""

    def __init__(self, workload: str, home: Path, log: FileLog) -> None:
        self.operations, self.states, self.kinds = len(log.operations), 0, 0
        self.wrong, self.first = Counter[str](), dict[str, str]()
        self._check, self._home, self._meaning = CHECKS[workload], home, Meaning(home)
        self._in_the_end = read_reports(one.text for one in log.operations if isinstance(one, Say))
        self._seen, self._checked = set[int](), set[int]()

    def look(self, state: CrashState) -> None:
        """Take a state: count it, recover its database, check what it means."""
        key = hash((len(state.reported), frozenset(state.files.items())))  # bytes keep their hash
        if key in self._seen:
            return
        self._seen.add(key)
        self.states += 1
        if (alike := self._meaning.of(state)) in self._checked:
            return
        self._checked.add(alike)
        self.kinds += 1
        place(state.files, self._home)
        goes_on = self.kinds % GOES_ON_EVERY == 0
        wrong: Wrong = []
        try:
            self._check(
                self._home, Known(read_reports(state.reported), self._in_the_end, state.synced, goes_on), wrong
            )
        except Exception as error:
            at = traceback.extract_tb(error.__traceback__)[-1]
            wrong.append(f"{type(error).__name__}: {error} ({Path(at.filename).name}:{at.lineno})")
        for one in wrong:
            fault = re.sub(r"[0-9a-f]{12,}", "...", one.replace(str(self._home), ""))[:200]
            self.wrong[fault] += 1
            self.first.setdefault(fault, f"cut {state.cut}, {state.model}, {state.kept}")


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Check ``size`` different states, over all workloads."""
    result, states = {}, 0
    for left, name in zip(range(len(WORKLOADS), 0, -1), WORKLOADS, strict=True):
        trial = tried(name, max(1, (size - states) // left), seed)  # what the short ones have not
        states += trial.states
        sys.stderr.writelines(f"{name}: {text}, first {at}\n" for text, at in trial.first.items())
        result[f"{name}: wrong, of {trial.states} states of {trial.operations} operations"] = zero(
            trial.wrong.total()
        )
    return {"different states": Figure(states), **result}

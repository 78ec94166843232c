"""A workload recorded, its crash states drawn, each put on a disk in memory and checked."""

import hashlib
import re
import shutil
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from tests.benchmarks.power_cuts.crash_checks import CHECKS, Bilingual, Findings, Known, read_said
from tests.benchmarks.power_cuts.disk_models import MODELS, CrashState, crash_states
from tests.benchmarks.power_cuts.file_operations import FileLog, Say
from tests.benchmarks.power_cuts.meaning import MEMORY_MAPPED, Meaning
from tests.benchmarks.power_cuts.strace_log import read_log, traced
from tests.benchmarks.power_cuts.workloads import WORKLOADS
from tests.proof.evidence import Figure, zero

IN_MEMORY = Path("/dev/shm")
MOST_ROUNDS, MOST_DIGESTS = 1000, 100
GOES_ON_EVERY = 20  # states until a campaign is gone on with, and read whole


@dataclass(slots=True)
class Tally:
    """What came of the states of a workload."""

    operations: int = 0
    drawn: int = 0
    states: int = 0
    kinds: int = 0
    told: Counter[str] = field(default_factory=Counter)
    wrong: Counter[str] = field(default_factory=Counter)
    first: dict[str, str] = field(default_factory=dict)


@contextmanager
def disk_in_memory() -> Iterator[Path]:
    """Yield a new folder on a disk in memory, where there is one."""
    with tempfile.TemporaryDirectory(dir=IN_MEMORY if IN_MEMORY.is_dir() else None, prefix="cut") as folder:
        yield Path(folder).resolve()


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


class Placer:
    """Puts states into a folder."""

    def __init__(self, home: Path) -> None:
        self._home = home

    def place(self, files: Mapping[str, bytes | None]) -> None:
        """Put a state there in place of what is there."""
        shutil.rmtree(self._home)
        self._home.mkdir()
        for name in sorted(files):
            content, path = files[name], self._home / name
            if content is None:
                path.mkdir()
            else:
                path.write_bytes(content)


def state_key(state: CrashState, digests: dict[int, tuple[bytes, bytes]]) -> bytes:
    """Return a state's hash; ``digests`` keeps those of contents by their identity."""
    whole = hashlib.blake2b(str(len(state.said)).encode(), digest_size=16)
    for name in sorted(state.files):
        content = state.files[name]
        whole.update(name.encode() + b"\0")
        if content is None:
            whole.update(b"/")
        elif len(content) < 1000:
            whole.update(content)
        else:
            kept = digests.get(id(content))
            if kept is None or kept[0] is not content:
                kept = digests[id(content)] = content, hashlib.blake2b(content, digest_size=16).digest()
            whole.update(kept[1])
    return whole.digest()


def tried(workload: str, states: int, seed: int) -> Tally:
    """Record a workload and check about ``states`` different states of it, from all of its length."""
    tally = Tally()
    with disk_in_memory() as scratch:
        log, home = recorded(workload, scratch)
        tally.operations = len(log.operations)
        trial = _Trial(
            workload, home, read_said(one.text for one in log.operations if isinstance(one, Say)), tally
        )
        least = len(MODELS) * 2 * len(log.operations)  # at each cut all kept, and none
        every, draws = max(1, least // states), max(1, 2 * states // least)
        for number in range(MOST_ROUNDS):
            before = tally.states
            for state in crash_states(log, seed + number, draws, every):
                trial.look(state)
            if tally.states >= states or tally.states - before < states // 100:
                break
    return tally


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Check ``size`` different states, over all workloads."""
    result, states = {}, 0
    for left, name in zip(range(len(WORKLOADS), 0, -1), WORKLOADS, strict=True):
        tally = tried(name, max(1, (size - states) // left), seed)  # what the short ones have not
        states += tally.states
        result[f"{name}: wrong, of {tally.states} states of {tally.operations} operations"] = zero(
            tally.wrong.total()
        )
    return {"different states": Figure(states), **result}


class _Trial:
    """Checks states that were not seen before, each meaning once."""

    def __init__(self, workload: str, home: Path, in_the_end: Bilingual, tally: Tally) -> None:
        self._workload, self._home, self._in_the_end, self._tally = workload, home, in_the_end, tally
        self._placer, self._meaning = Placer(home), Meaning(home)
        self._seen, self._checked = set[bytes](), set[bytes]()
        self._digests: dict[int, tuple[bytes, bytes]] = {}

    def look(self, state: CrashState) -> None:
        """Take a state: count it, recover its database, check what it means."""
        tally = self._tally
        tally.drawn += 1
        if len(self._digests) > MOST_DIGESTS:
            self._digests.clear()
        if (key := state_key(state, self._digests)) in self._seen:
            return
        self._seen.add(key)
        tally.states += 1
        if (alike := self._meaning.of(state)) in self._checked:
            return
        self._checked.add(alike)
        tally.kinds += 1
        self._placer.place(state.files)
        goes_on = tally.kinds % GOES_ON_EVERY == 0
        known = Known(read_said(state.said), self._in_the_end, state.synced, goes_on)
        _check(self._workload, self._home, state, known, tally)


def _check(workload: str, home: Path, state: CrashState, known: Known, tally: Tally) -> None:
    found = Findings()
    try:
        CHECKS[workload](home, known, found)
    except Exception as error:
        at = traceback.extract_tb(error.__traceback__)[-1]
        found.wrong.append(f"{type(error).__name__}: {error} ({Path(at.filename).name}:{at.lineno})")
    tally.told.update(_shortened(one, home) for one in found.told)
    for one in found.wrong:
        tally.wrong[key := _shortened(one, home)] += 1
        tally.first.setdefault(key, f"cut {state.cut}, {state.model}, {state.kept}")


def _shortened(text: str, home: Path) -> str:
    return re.sub(r"[0-9a-f]{12,}", "...", text.replace(str(home), ""))[:200]

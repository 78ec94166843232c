"""One thing done on a disk that fails at its n-th call; then the disk is whole again, and all is looked at."""

import ctypes
import errno
import os
import shutil
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from sqlalchemy import text

from fixtures_db.campaigns import campaign, verify_steps
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import accept_calibration, verify_chain
from station.errors import BUG, explain
from station.files.sha256sums import verify_folder
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.stream.recorder.accepted_step_writer import CampaignRecorder, open_campaign
from tests.benchmarks.failing_disks import SHIM
from tests.fixtures_db.factory import facts, solution
from tests.station.applying import inputs
from tests.station.commands.program import quietly
from tests.station.guide.recorded import SITE, TAPE, UNIT, step

WRITES, SYNCS, NAMES = 1, 2, 4
FAULTS = {
    "disk full": (errno.ENOSPC, WRITES | NAMES, True),
    "quota": (errno.EDQUOT, WRITES | NAMES, True),
    "read-only": (errno.EROFS, WRITES | NAMES, True),
    "EIO on a write": (errno.EIO, WRITES, False),
    "EIO on fsync": (errno.EIO, SYNCS, False),
}
Wrong = list[str]
STORED = 2  # calibrations


@dataclass(slots=True)
class Outcome:
    """What came of a job at all calls of a fault."""

    trials: int = 0
    refused: int = 0
    wrong: Counter[str] = field(default_factory=Counter)


class FailingDisk:
    """What lies below a folder, as if on a disk that fails when told; ``has_failed``, by the last `heal`."""

    has_failed = False

    def __init__(self, folder: Path) -> None:
        self._folder = os.fsencode(folder)
        self._shim = ctypes.CDLL(os.environ[SHIM])
        self._shim.arm_disk.argtypes = (
            ctypes.c_char_p, ctypes.c_int, ctypes.c_long, ctypes.c_int, ctypes.c_int, ctypes.c_double,
        )  # fmt: skip

    def arm(self, kinds: int, nth: int, error: int, *, stays: bool = False, delay_s: float = 0.0) -> None:
        """Let the ``nth`` call of ``kinds`` from now on fail with ``error``, with ``stays`` all after it too."""
        self._shim.arm_disk(self._folder, kinds, nth, error, stays, delay_s)

    def heal(self) -> None:
        """Let all calls succeed again."""
        self.has_failed |= self._shim.calls_failed() > 0
        self._shim.arm_disk(b"", 0, 0, 0, 0, 0.0)


class Refused(Exception):
    """A command said no: its code and line."""

    def __init__(self, code: int, line: str) -> None:
        self.code, self.line = code, line
        super().__init__(line)


def accept(home: Path, disk: FailingDisk, arm: Callable[[], None]) -> Wrong:
    """Accept a step behind two; what fails is accepted once there is room again."""
    folder = home / "campaign"
    folder.mkdir()
    with open_db(home / "station.db") as database:
        recorder = open_campaign(folder, UNIT, SITE, database)
        for position in (1, 2):
            _record(recorder, position)
        refused = None
        arm()
        try:
            _record(recorder, 3)
        except Exception as error:
            refused = error
        disk.heal()
        wrong = _accepted(folder, home, 3 if refused is None else 2, atleast=True)
        if refused is not None:
            _record(recorder, 3)
    wrong += _accepted(folder, home, 3, atleast=False)
    with open_db(home / "station.db") as database:
        reopen(folder, database)
    wrong += _accepted(folder, home, 3, atleast=False)
    if refused is not None:
        raise _with(refused, wrong)
    return wrong


def _record(recorder: CampaignRecorder, position: int) -> None:
    first = 80 * position
    FolderRecorder(recorder).accept(step(position), TAPE, [(first, first + 50)], kept_seat=None, turn_on=1)


def _accepted(folder: Path, home: Path, number: int, *, atleast: bool) -> Wrong:
    with open_db(home / "station.db") as database, database.read() as session:
        rows = [(one.name, one.file) for one in campaign(session, str(folder)).steps if not one.superseded]
        wrong = [fault.row for fault in verify_steps(session, str(folder))]
    names = [name for name, _ in rows]
    if len(names) < number or len(set(names)) != len(names) or (not atleast and len(names) != number):
        wrong.append(f"{number} steps accepted, {len(names)} there")
    verified = verify_folder(folder)
    return wrong + [f"{file} not verified" for _, file in rows if file not in verified]


def store(home: Path, disk: FailingDisk, arm: Callable[[], None]) -> Wrong:
    """Store a calibration behind one, in a database that is closed behind each."""
    refused = None
    for number in range(1, STORED + 1):
        if number == STORED:
            arm()
        try:
            with open_db(home / "station.db") as database, database.write() as session:
                accept_calibration(session, solution(number * 1e-3), facts("S1"))
        except Exception as error:
            refused = error
    disk.heal()
    with open_db(home / "station.db") as database, database.read() as session:
        wrong = [fault.row for fault in verify_chain(session)]
        there = session.execute(text("SELECT count(*) FROM calibrations")).scalar()
    if refused is None and there != STORED:
        wrong.append(f"{there} of {STORED} calibrations")
    if refused is not None:
        raise _with(refused, wrong)
    return wrong


def apply(home: Path, disk: FailingDisk, arm: Callable[[], None]) -> Wrong:
    """Apply a calibration to a log, over an older result."""
    calibration = inputs.calibration_file(home)
    log = inputs.write_csv(home / "drive.csv", {name: column[:300] for name, column in inputs.COLUMNS.items()})
    out = home / "out.npz"
    ask = ["apply", str(log), "--calibration", str(calibration), "--out", str(out)]
    _run(ask)
    before = out.read_bytes()
    arm()
    try:
        _run([*ask, "--units", "g,deg/s"])
    except Refused as error:
        disk.heal()
        _run([*ask, "--units", "g,deg/s"])
        raise _with(error, [] if out.read_bytes() != before else ["the old result stays"]) from error
    finally:
        disk.heal()
    return []


def _run(arguments: list[str]) -> None:
    code, output = quietly(*arguments)
    if code:
        raise Refused(code, "\n".join(x for x in output.splitlines() if not x.startswith("inferred")))


def _with(error: Exception, wrong: Wrong) -> Exception:
    error.add_note("\n".join(wrong))
    return error


JOBS: dict[str, Callable[[Path, FailingDisk, Callable[[], None]], Wrong]] = {
    one.__name__: one for one in (accept, store, apply)
}


def tried(job: str, fault: str, scratch: Path, every: int) -> Outcome:
    """Let a fault come at each so manieth call of a job, until it has no more calls."""
    outcome, home = Outcome(), scratch / "home"
    for nth in count(1, every):
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir()
        if not _came(outcome, job, fault, home, nth):
            break
    return outcome


def _came(outcome: Outcome, job: str, fault: str, home: Path, nth: int) -> bool:
    """Do the job with the fault at its ``nth`` call; return whether it came to that."""
    (error, kinds, stays), disk = FAULTS[fault], FailingDisk(home)
    wrong, line, code = list[str](), "", 0
    try:
        wrong = JOBS[job](home, disk, lambda: disk.arm(kinds, nth, error, stays=stays))
    except Exception as raised:
        code, line = (raised.code, raised.line) if isinstance(raised, Refused) else explain(raised)
        wrong = [one for note in getattr(raised, "__notes__", ()) for one in note.splitlines() if one]
    finally:
        disk.heal()
    if disk.has_failed:
        output = line.replace(str(home), "").strip()
        if output and (code == BUG or "\n" in output):
            wrong.append(f"code {code}: {output}")
        outcome.trials += 1
        outcome.refused += bool(output)
        outcome.wrong.update(one[:300] for one in wrong)
    return disk.has_failed

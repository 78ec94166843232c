"""A disk that takes long for each write, met by whole programs: recording, guided steps, results, `verify`.

Each process below gets the shim and slows itself from its first call on. Nothing that was accepted may be lost, no
sample of the line be missing, nothing be said of the line that is only true of the disk, and a screen hears of it.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import patch

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.campaigns import campaign
from fixtures_db.database import open_db
from procedures.campaign.plan_steps import FreePosition
from station.files.campaign_folder.plan_toml import write_plan
from station.files.mcap_files import read_step
from station.files.setup import Setup
from station.files.sha256sums import verify_folder
from station.guide.client import EngineConnection
from station.guide.command import OperatorCommand
from station.guide.start_engine import EngineOptions, engine_process
from station.guide.view import ENDED_STAGES, CalibrationView
from station.stream.recorder.plain_recording import RECORDING_FILE
from tests.benchmarks.failing_disks.failing_disk import NAMES, SHIM, SYNCS, WRITES, FailingDisk
from tests.benchmarks.failing_disks.trials import JOBS, Wrong
from tests.station.commands.program import STATION
from tests.station.results.certificate.factory import EXAMPLE, accepted

RECORDED_S, DWELL_S, STEPS, PERIOD_S = 12.0, 10.0, 1, 0.01
SLOW = "the disk for "  # what a screen says of it
ORDER = ("--customer", "Sky AG", "--customer-address", "Town", "--customer-email", "imu@sky.example",
         "--received", "2026-03-02", "--condition", "good")  # fmt: skip


@dataclass(slots=True)
class Slow:
    """What came of a job: how long it took [s], what was wrong."""

    seconds: float = 0.0
    wrong: Wrong = field(default_factory=list)


@contextmanager
def slowed(home: Path, delay_s: float) -> Iterator[None]:
    """Let each process that is started meanwhile wait at each change of what lies below ``home``."""
    more = {"LD_PRELOAD": os.environ[SHIM], "SLOW_DISK_BELOW": str(home), "SLOW_DISK_S": str(delay_s)}
    with patch.dict(os.environ, more):
        yield


def in_this_process(job: str) -> Callable[[Path, float], Wrong]:
    """Return a job of `trials` on a slow disk."""

    def do(home: Path, delay_s: float) -> Wrong:
        disk = FailingDisk(home)
        try:
            return JOBS[job](home, disk, lambda: disk.arm(WRITES | SYNCS | NAMES, 0, 0, delay_s=delay_s))
        finally:
            disk.heal()

    return do


def station(home: Path, delay_s: float, *arguments: object) -> tuple[int, str]:
    """Run a command on the slow disk; return its exit code and what it said on stderr."""
    with slowed(home, delay_s):
        command = [sys.executable, "-P", "-c", STATION, *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def record(home: Path, delay_s: float) -> Wrong:
    """Record a device that goes on sending; no sample lacks, and the journal of raw bytes is whole."""
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=PERIOD_S), 5) as device:
        code, said = station(home, delay_s, "record", device.url, "--seconds", RECORDED_S, "--out", home / "r")
    wrong = [] if (code, said) == (0, "") else [f"record: code {code}, {said}"]
    for path in sorted((home / "r").glob("*.mcap")):
        step = read_step(path)
        wrong += [f"{path.name}: {step.damage}"] if step.damage else []
        if path.name == RECORDING_FILE:
            seconds = (step.device_ns[-1] - step.device_ns[0]) / 1e9 + PERIOD_S
            if (lacking := round(seconds / PERIOD_S) - len(step)) or seconds < RECORDED_S - PERIOD_S:
                wrong.append(f"{lacking} samples lack of {seconds:g} s")
    verify_folder(home / "r")
    return wrong


def guided(home: Path, delay_s: float) -> Wrong:
    """Record steps of a guided campaign with a screen beside it, leave, and verify it."""
    write_plan(home / "plan.toml", [FreePosition(number, DWELL_S) for number in range(1, STEPS + 1)])
    open_db(home / "station.db").close()
    seen = list[CalibrationView]()
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=PERIOD_S), 5) as device, slowed(home, delay_s):
        setup = Setup(url=device.url, latitude_deg=31.17)
        begin = OperatorCommand(verb="begin", setup=setup)
        options = EngineOptions(
            root=home / "c", database=str(home / "station.db"), setup=setup, warms_up=False,
            plan=home / "plan.toml", hands=device.control, move_s=5.0, first=begin,
        )  # fmt: skip
        with engine_process(options) as socket, EngineConnection(socket) as screen:
            screen.changed = lambda: seen.append(screen.view)
            _until(lambda: screen.view.done >= STEPS or screen.view.stage in ENDED_STAGES, 300 * delay_s + 120)
            screen.send(OperatorCommand(verb="leave"))
            _until(lambda: screen.view.stage in ENDED_STAGES, 60 * delay_s + 60)
    wrong = [f"link: {view.link.word} {view.link.text}" for view in seen if view.link and not view.link.is_live]
    wrong += [f"failed: {view.error}" for view in seen[-1:] if view.stage == "failed"]
    if delay_s >= 1 and not any(SLOW in view.hint for view in seen):
        wrong.append("no screen heard that the disk is slow")
    said = [event.text for view in seen for event in view.events if event.sound == "accepted"]
    return sorted(set(wrong)) + _campaign_whole(home, delay_s, len(set(said)))


def _campaign_whole(home: Path, delay_s: float, said: int) -> Wrong:
    [folder] = [path.parent for path in (home / "c").rglob("campaign.toml")]
    with open_db(home / "station.db") as database, database.read() as session:
        there = len(campaign(session, str(folder.resolve())).steps)
    wrong = [f"{said} steps said, {there} accepted"] if not said <= there == STEPS else []
    code, text = station(home, delay_s, "verify", folder, "--db", home / "station.db")
    return [*wrong, *([f"verify: {text}"] if code else [])]


def certificate(home: Path, delay_s: float) -> Wrong:
    """Issue a certificate with its XML, look at the database, keep an anchor."""
    database = ("--db", home / "station.db")
    with open_db(home / "station.db") as opened, opened.write() as session:
        accepted(session)
    orders: Mapping[str, tuple[object, ...]] = {
        "certificate": ("S0101", "--laboratory", EXAMPLE, *ORDER, "--dcc", "--out", home / "c.html"),
        "verify": ("--write-anchor", home / "anchor.toml"),
    }
    wrong = Wrong()
    for command, more in orders.items():
        code, said = station(home, delay_s, command, *more, *database)
        wrong += [f"{command}: code {code}, {said}"] if code else []
    code, said = station(home, 0.0, "verify", "--anchor", home / "anchor.toml", *database)
    return [*wrong, *([f"anchor: code {code}, {said}"] if code else [])]


def _until(what: Callable[[], bool], seconds: float) -> None:
    deadline = time.monotonic() + seconds
    while not what():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not within {seconds:g} s")
        time.sleep(0.05)


SLOW_JOBS: Mapping[str, Callable[[Path, float], Wrong]] = {
    "accept": in_this_process("accept"), "store": in_this_process("store"), "apply": in_this_process("apply"),
    "record": record, "guided": guided, "certificate": certificate,
}  # fmt: skip


def tried_slow(job: str, scratch: Path, delay_s: float) -> Slow:
    """Do a job on a disk that takes ``delay_s`` for each change."""
    home, began, found = scratch / job, time.monotonic(), Slow()
    home.mkdir()
    try:
        found.wrong += SLOW_JOBS[job](home, delay_s)
    except Exception as error:
        found.wrong.append(f"{type(error).__name__}: {error}")
    found.seconds = time.monotonic() - began
    return found

"""What must hold in every state of the disk after a power cut, for each of the workloads.

A check is given the folder as the cut left it, and what the program had said by then; it adds what is wrong.
"""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import Any

from sqlalchemy import text

from fixtures_db.campaigns import campaign, verify_steps
from fixtures_db.database import Database, open_db
from fixtures_db.migrations import HEAD
from fixtures_db.verification import alterations
from station.errors import BUG, exit_code
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.mcap_files import read_step
from station.files.mcap_files.reader import read_stream
from station.files.sha256sums import SHA256SUMS, verify_folder
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.stream.recorder.accepted_step_writer import CampaignRecorder
from tests.benchmarks.kills import STEPS, record
from tests.benchmarks.power_cuts.workloads import CAMPAIGN, DATABASE, GUIDED, sha256
from tests.station.commands.program import quietly
from tests.station.guide.recorded import TAPE, step

Reports = list[dict[str, Any]]
Wrong = list[str]


@dataclass(frozen=True, slots=True)
class Known:
    """What a check knows with the folder: what was reported by the cut, in the end, and what was synced."""

    reported: Reports
    in_the_end: Reports
    synced: Mapping[str, bytes]
    goes_on: bool = False


def refused(error: Exception) -> None:
    """Pass what is refused on purpose; anything else is a bug and is raised again."""
    if exit_code(error) is None:
        raise error


def _from_tape(recorder: CampaignRecorder) -> str:
    FolderRecorder(recorder).accept(step(9), TAPE, [(560, 600)], kept_seat=None, turn_on=1)
    return step(9).name


def _by_guide(recorder: CampaignRecorder) -> str:
    record(GUIDED, STEPS[GUIDED], recorder, FolderRecorder)
    return STEPS[GUIDED].name


def check_campaign(
    home: Path, known: Known, wrong: Wrong, go_on: Callable[[CampaignRecorder], str] = _from_tape
) -> None:
    """No accepted step is lost or there twice, and the campaign goes on, by ``go_on``."""
    folder, accepted = home / CAMPAIGN, [one for one in known.reported if "step" in one]
    begun = any("begun" in one for one in known.reported)
    if not (home / DATABASE).exists() or not folder.exists():
        if begun:
            wrong.append("lost: no database or no folder")
        return
    with open_db(home / DATABASE) as database:
        _whole(database, wrong)
        if folder.exists() and accepted:
            code, line = quietly("verify", folder, "--db", home / DATABASE)
            if code == BUG or line.count("\n") > 1:
                wrong.append(f"verify: {line}")
            if code and not begun:
                wrong.append("verify")
        try:
            recorder = reopen(folder, database)
        except Exception as error:
            refused(error)
            if begun:
                wrong.append(f"cannot be resumed: {error}")
            return
        if known.goes_on:
            accepted.append({"step": go_on(recorder)})
        _steps(database, folder, accepted, wrong, full=known.goes_on)


def _steps(database: Database, folder: Path, accepted: Reports, wrong: Wrong, *, full: bool) -> None:
    with database.read() as session:
        rows = [(one.name, one.file, one.sha256, one.superseded) for one in campaign(session, str(folder)).steps]
        faults = verify_steps(session, str(folder))
    wrong += [f"chain: {fault.row}" for fault in faults]
    promised, there = Counter(one["step"] for one in accepted), Counter(row[0] for row in rows)
    wrong += [f"{name} lost" for name in promised if there[name] < promised[name]]
    if (there - promised).total() > 1:  # one may have been on its way
        wrong.append(f"twice: {there - promised}")
    valid = Counter(name for name, _, _, superseded in rows if not superseded)
    wrong += [f"{name} is valid {number} times" for name, number in valid.items() if number != 1]
    hashes = {(file, sha) for _, file, sha, _ in rows}
    wrong += [
        f"{one['file']} is another"
        for one in accepted
        if "file" in one and (one["file"], one["sha256"]) not in hashes
    ]
    verified = verify_folder(folder) if rows else []
    wrong += [f"{file} not verified" for _, file, _, _ in rows if file not in verified]
    if rows and accepted and full:
        named = {one.name for one in read_campaign(folder).campaign.dwells}
        wanted = {file for _, file, _, superseded in rows if not superseded}
        if named != wanted:
            wrong.append(f"campaign.toml names {sorted(named)}, the database {sorted(wanted)}")


def _whole(database: Database, wrong: Wrong) -> None:
    with database.read() as session:
        integrity = session.execute(text("PRAGMA integrity_check")).scalar()
        if integrity != "ok":
            wrong.append(f"integrity_check: {integrity}")
        wrong += [f"chain: {fault.row}: {fault.found}" for fault in alterations(session, None)]


def check_recording(home: Path, known: Known, wrong: Wrong) -> None:
    """What was synced is read, and nothing that was not recorded."""
    final = {name: one for report in known.in_the_end for name, one in report.get("files", {}).items()}
    for path, content in known.synced.items():
        if not path.endswith(".mcap"):
            continue
        there = home / path
        if not there.exists():
            if _bytes_in(content):
                wrong.append(f"{there.name} is not there")
            continue
        try:
            read = read_step(there)
        except Exception as error:
            refused(error)
            if _bytes_in(content):
                wrong.append(f"{there.name} cannot be read: {error}")
            continue
        if len(read.raw) < _bytes_in(content):
            wrong.append(f"{there.name}: {len(read.raw)} of {_bytes_in(content)} synced chunks")
        if read.damage is None and sha256(there) != final.get(there.name):
            wrong.append(f"{there.name}: other than recorded, and not said")
    check_files(home, known, wrong)


_CHUNKS: dict[bytes, int] = {}


def _bytes_in(content: bytes) -> int:
    """Return how many chunks of raw bytes can be read of what is certain."""
    if content not in _CHUNKS:
        try:
            _CHUNKS[content] = len(read_stream(BufferedReader(BytesIO(content)), Path("x.mcap")).raw)
        except Exception as error:
            refused(error)
            _CHUNKS[content] = 0
    return _CHUNKS[content]


def check_files(home: Path, known: Known, wrong: Wrong) -> None:
    """Each file is whole or not there; said to be written, it is there."""
    ever: dict[str, list[str]] = {}
    for one in known.in_the_end:
        for name, sha in one.get("files", {}).items():
            ever.setdefault(name, []).append(sha)
    must = {name: sha for one in known.reported for name, sha in one.get("files", {}).items()}
    there = {
        path.name: sha256(path) for path in home.rglob("*")
        if path.name in ever and path.is_file() and not re.search(r"(^|/)\.", str(path.relative_to(home)))
    }  # fmt: skip
    for name, sha in there.items():
        if name == SHA256SUMS:
            continue  # it grows
        if sha not in ever[name]:
            if not name.endswith(".mcap") or name.startswith("out"):
                wrong.append(f"{name} is neither old nor new")
        elif name in must and ever[name].index(sha) < ever[name].index(must[name]):
            wrong.append(f"{name} is an old one")
    wrong += [f"{name} is lost" for name in must if name not in there and not _is_on_its_way(name, ever)]
    for name in there:
        sidecar = f"{name}.json"
        if sidecar in there and ever[name].index(there[name]) != ever[sidecar].index(there[sidecar]):
            wrong.append(f"{sidecar} is not of {name}")


def _is_on_its_way(name: str, ever: Mapping[str, list[str]]) -> bool:
    """Say whether a file goes before what it tells of is replaced."""
    return name.startswith("out.") and name.endswith(".json") and len(ever[name]) > 1


def check_database(home: Path, known: Known, wrong: Wrong) -> None:
    """What was stored is there, whole, at the newest schema; files next to it as in `check_files`."""
    rows = {table: number for one in known.reported for table, number in one.get("rows", {}).items()}
    if not (home / DATABASE).exists():
        if rows:
            wrong.append("lost: no database")
        return
    with open_db(home / DATABASE) as database:
        _whole(database, wrong)
        with database.read() as session:
            for table, number in rows.items():
                there = session.execute(text(f"SELECT count(*) FROM {table}")).scalar()
                if there < number:
                    wrong.append(f"{number - there} of {table} lost")
            if session.execute(text("SELECT version_num FROM alembic_version")).scalar() != HEAD:
                wrong.append("not migrated")
    check_files(home, known, wrong)


def check_upgrade(home: Path, known: Known, wrong: Wrong, before: Mapping[str, int]) -> None:
    """As `check_database`; the rows that the old database held are there in any case."""
    check_database(home, replace(known, reported=[{"rows": before}, *known.reported]), wrong)


CHECKS: dict[str, Callable[[Path, Known, Wrong], None]] = {
    "campaign": check_campaign,
    "recording": check_recording,
    "files": check_files,
    "fixtures": check_database,
    "migration": partial(check_upgrade, before={"slabs": 40, "imus": 40}),
    "guided": partial(check_campaign, go_on=_by_guide),
    "journal_begun": partial(check_upgrade, before={"calibrations": 2, "steps": 12, "certificates": 2}),
}


def read_reports(texts: Iterable[str]) -> Reports:
    """Return what was reported, a line of JSON each; other lines are left out."""
    lines = (line for one in texts for line in one.splitlines())
    return [json.loads(line) for line in lines if line.startswith('{"')]

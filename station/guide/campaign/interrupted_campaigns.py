"""Campaigns that were interrupted: how one is resumed, cancelled, or removed if it was killed before it began.

At accept the order is file, ``SHA256SUMS``, ``campaign.toml``, row in the database. After a kill in between,
`reopen` accepts a step with a row, adopts one named in ``campaign.toml``, and never uses a file that nothing
names.
"""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from datetime import UTC, datetime
from fnmatch import fnmatch
from pathlib import Path

from fixtures_db.campaigns import accept_step, campaign, known_campaign, remove_campaign, set_state
from fixtures_db.database import Database
from fixtures_db.errors import CampaignInUse
from fixtures_db.schema import StepRow
from procedures.errors import ErrorCode
from station.errors import DataRefused, cannot_write
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.opening import sha256_inside
from station.files.sha256sums import SHA256SUMS, read_hashes
from station.guide.campaign.folder_lock import LOCK_FILE
from station.stream.recorder.accepted_step_writer import TOML, CampaignRecorder, step_of

RESUMABLE_STATES = ("recording", "recorded")


def reopen(folder: Path, database: Database) -> CampaignRecorder:
    """Resume a campaign: reconcile folder and database, then return its recorder.

    Doing so again changes nothing. Hold the folder's `folder_lock` meanwhile.

    Raises
    ------
    DataRefused
        If an accepted file is gone or is not what was accepted, or ``campaign.toml`` does not name it.
    NotInDatabase, CampaignInUse
        If the database does not know the folder, or a calibration was stored from it.
    """
    key = str(folder.resolve())
    tables, _, _ = read_campaign_toml(folder)
    named = {step.name: table.file for table in tables.steps() if (step := step_of(table)) is not None}
    with database.read() as session:
        row = campaign(session, key)
        steps, state = list(row.steps), row.state
    if state not in RESUMABLE_STATES:
        raise CampaignInUse(key)
    adopted = _reconciled(folder, steps, named)
    if adopted or state != RESUMABLE_STATES[0]:
        with database.write() as session:
            set_state(session, key, RESUMABLE_STATES[0])
            for name, sha256 in adopted.items():
                file = named[name]
                written = datetime.fromtimestamp((folder / file).stat().st_mtime, UTC)
                accept_step(session, key, name=name, file=file, sha256=sha256, accepted_utc=written)
    for aside in (*folder.glob(".*.part"), *folder.glob(".*.tmp")):
        aside.unlink()
    return CampaignRecorder(folder, tables, database, Counter([*(step.name for step in steps), *adopted]))


def _reconciled(folder: Path, steps: Sequence[StepRow], named: Mapping[str, str]) -> dict[str, str]:
    """Check every accepted file; return the hashes of those in ``campaign.toml`` that have no row, by step."""
    hashes, known = _hashes(folder), {step.file for step in steps}
    for step in steps:
        _check(folder, step.file, step.sha256, hashes)
        file = named.get(step.name, "")
        if not step.superseded and file != step.file and (file in known or not file):
            raise _refusal(folder / CAMPAIGN_TOML, f"file = {file!r}", f"{step.file!r}, an accepted step")
    adopted = {name: hashes.get(file, "") for name, file in named.items() if file not in known}
    for name, sha256 in adopted.items():
        _check(folder, named[name], sha256, hashes)
    return adopted


def cancel_campaign(folder: Path, database: Database) -> None:
    """Give a campaign up: the database is as it was before it began; its folder and files stay, to be solved.

    Raises
    ------
    NotInDatabase, CampaignInUse
        If the database does not know the folder, or a calibration was stored from it.
    """
    with database.write() as session:
        remove_campaign(session, str(folder.resolve()))


def _hashes(folder: Path) -> dict[str, str]:
    if not (folder / SHA256SUMS).exists():  # before the first step
        return {}
    return {name: sha256 for name, (sha256, _) in read_hashes(folder).items()}


def _check(folder: Path, file: str, sha256: str, hashes: Mapping[str, str]) -> None:
    if hashes.get(file) != sha256 or not sha256:
        raise _refusal(folder / SHA256SUMS, f"{hashes.get(file, 'no hash')} for {file}", sha256 or "its hash")
    if not (folder / file).exists():
        raise _refusal(folder / file, "no such file", "the recording that was accepted")
    found = sha256_inside(folder, file, folder / SHA256SUMS, None)
    if found != sha256:
        raise _refusal(folder / file, f"sha256 {found}", f"{sha256} as accepted")


def _refusal(path: Path, found: str, expected: str) -> DataRefused:
    remedy = "restore the folder from a copy, or start a new campaign"
    return DataRefused(path, None, found, expected, remedy, ErrorCode.ALTERED)


RAW_RECORDING = "session_*.mcap"
KNOWN = (
    LOCK_FILE, RAW_RECORDING, "gnss_session_*.mcap", "gnss_*.mcap", ".*.tmp", "setup.json", "unit.json",
    "wanted.json", "plan.toml", "gnss.json", "SHA256SUMS", "effect_*.toml",
)  # fmt: skip


def is_unfinished(names: Collection[str], has_row: bool = False) -> bool:
    """Say whether a folder holds such a beginning: the recording that is opened first, or the lock alone.

    A ``campaign.toml`` in the same folder has no step, as there is no step's file: the program was killed before
    the campaign had its row in the database. ``has_row`` says that it has one.
    """
    is_begun = any(fnmatch(name, RAW_RECORDING) for name in names) or set(names) <= {LOCK_FILE}
    known = KNOWN if has_row else (*KNOWN, TOML)
    return is_begun and all(any(fnmatch(name, each) for each in known) for name in names)


def has_row(database: Database, folder: Path) -> bool:
    """Say whether the database has a campaign of this folder."""
    with database.read() as session:
        return known_campaign(session, str(folder.resolve())) is not None


def clear_unfinished(folder: Path) -> None:
    """Remove the notes of such a beginning; what was read from ports stays. Hold the folder's lock meanwhile."""
    try:
        for file in folder.iterdir():
            if file.name != LOCK_FILE and file.suffix != ".mcap":
                file.unlink()
    except OSError as error:
        raise cannot_write(folder, error) from error

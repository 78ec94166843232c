"""What a worker does with one campaign: hash its files, solve it and diagnose it.

Both functions are sent the name of a folder and return small documents; the recordings stay where they are.
"""

import hashlib
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.opening import open_inside
from station.files.sha256sums import SHA256SUMS, read_hashes


@dataclass(frozen=True, slots=True)
class CheckTask:
    """A folder to hash, and the files that the database says are in it."""

    folder: str
    recorded: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SolveTask:
    """A folder to solve and the SHA-256 of each file that goes into it, by name."""

    folder: str
    files: Mapping[str, str]


def check_files(item: CheckTask) -> dict[str, Any]:
    """Hash a campaign's files.

    Returns
    -------
    dict
        ``inputs``: the names of what a solve reads; ``found``: name to SHA-256 of every file that is there;
        ``sums``: the same as ``SHA256SUMS`` has it, None where there is none; ``fault``: why that cannot be read.

    Raises
    ------
    DataRefused
        If there is no such folder here.
    """
    folder = Path(item.folder)
    if not folder.is_dir():
        host = socket.gethostname()
        raise DataRefused(folder, None, f"no such folder on {host}", "one that every worker can read",
                          "share it with that machine under the same path",
                              code=ErrorCode.FILE_MISSING)  # fmt: skip
    inputs, sums, fault = _inputs(folder), None, ""
    try:
        sums = {name: sha256 for name, (sha256, _) in read_hashes(folder).items()}
    except DataRefused as error:
        fault = str(error) if (folder / SHA256SUMS).exists() else ""
    names = dict.fromkeys([*inputs, *(sums or {}), *item.recorded])
    found = {name: sha256 for name in names if (sha256 := _sha256(folder, name)) is not None}
    return {"inputs": inputs, "found": found, "sums": sums, "fault": fault}


def resolve_one(task: SolveTask) -> dict[str, Any]:
    """Solve and diagnose a campaign: ``solution``, a solution/1, and ``diagnosis``, a diagnosis/2 without it.

    It is solved as its calibration was: where a diagnosis added effects, with them.

    Raises
    ------
    DataRefused
        If it breaks a rule of `campaign/1`, or has other bytes than whoever asks saw.
    NotObservable
        If neither triad can be solved.
    """
    loaded = read_for_solve([Path(task.folder)])[0]
    for name, sha256 in loaded.files.items():
        if (expected := task.files.get(name)) != sha256:
            raise DataRefused(Path(task.folder) / name, None, f"sha256 {sha256} on {socket.gethostname()}",
                              f"{expected} as a moment ago", "let nobody write there, then repeat")  # fmt: skip
    from procedures.calibration.joint_calibration import solve
    from station.results.diagnosis.closed_loop import added_effects, close_loop
    from station.results.solution_json import solution_document

    closed = close_loop([loaded])
    is_with_effects = bool(loaded.effects or added_effects(loaded.folder))
    solution = closed.solution if is_with_effects else solve([loaded.campaign])
    diagnosis = {name: part for name, part in closed.document.items() if name != "solution"}
    return {
        "solution": solution_document(solution, [loaded], closed.effects if is_with_effects else ()),
        "diagnosis": diagnosis,
    }


def _inputs(folder: Path) -> list[str]:
    try:
        tables = read_campaign_toml(folder)[0]
        return [CAMPAIGN_TOML, *(step.file for step in tables.steps()), *tables.effect_files()]
    except DataRefused:  # the solve will say it again, and whether the file was altered shows in its hash
        return [CAMPAIGN_TOML]


def _sha256(folder: Path, name: str) -> str | None:
    try:
        with open_inside(folder, name, folder, None) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (DataRefused, OSError):
        return None

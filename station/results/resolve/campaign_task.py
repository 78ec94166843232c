"""What a worker does with one campaign: hash its files, diagnose it, then all that `PARTS` names.

Both functions are sent the name of a folder and return small documents; the recordings stay where they are.
"""

import hashlib
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.files.opening import open_inside
from station.files.sha256sums import SHA256SUMS, read_hashes

if TYPE_CHECKING:
    from station.results.diagnosis.closed_loop import ClosedLoop


def _solution(loaded: LoadedCampaign, closed: "ClosedLoop") -> dict[str, Any]:
    """Solve a campaign as its calibration was solved: where a diagnosis added effects, with them."""
    from procedures.calibration.joint_calibration import solve
    from station.results.diagnosis.closed_loop import added_effects
    from station.results.solution_json import solution_document

    solution = closed.solution if added_effects(loaded.folder) else solve([loaded.campaign])
    return solution_document(solution, [loaded])


def _diagnosis(_: LoadedCampaign, closed: "ClosedLoop") -> dict[str, Any]:
    """Return a campaign's diagnosis/1 but for its solution, which is long and stands beside it."""
    return {name: part for name, part in closed.document.items() if name != "solution"}


Part = Callable[[LoadedCampaign, "ClosedLoop"], dict[str, Any]]
PARTS: Mapping[str, Part] = {"solution": _solution, "diagnosis": _diagnosis}
"""What is done with each campaign, by the name under which its document is kept."""


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
                          "share it with that machine under the same path")  # fmt: skip
    inputs, sums, fault = _inputs(folder), None, ""
    try:
        sums = {name: sha256 for name, (sha256, _) in read_hashes(folder).items()}
    except DataRefused as error:
        fault = str(error) if (folder / SHA256SUMS).exists() else ""
    names = dict.fromkeys([*inputs, *(sums or {}), *item.recorded])
    found = {name: sha256 for name in names if (sha256 := _sha256(folder, name)) is not None}
    return {"inputs": inputs, "found": found, "sums": sums, "fault": fault}


def resolve_one(task: SolveTask) -> dict[str, Any]:
    """Do all `PARTS` with a campaign; return their documents by name.

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
    from station.results.diagnosis.closed_loop import close_loop

    closed = close_loop([loaded])
    return {name: part(loaded, closed) for name, part in PARTS.items()}


def _inputs(folder: Path) -> list[str]:
    try:
        return [CAMPAIGN_TOML, *(step.file for step in read_campaign_toml(folder)[0].steps())]
    except DataRefused:  # the solve will say it again, and whether the file was altered shows in its hash
        return [CAMPAIGN_TOML]


def _sha256(folder: Path, name: str) -> str | None:
    try:
        with open_inside(folder, name, folder, None) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (DataRefused, OSError):
        return None

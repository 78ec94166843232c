"""Many campaigns, each solved again by whoever has time, to one `resolve/1`, and that as text to read.

The database is only read.
"""

import socket
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from textwrap import wrap
from typing import Any, TextIO

from fixtures_db.database import Database
from fixtures_db.imu_models import Limit, limits_of
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.opening import sha256_inside
from station.files.sha256sums import SHA256SUMS, read_hashes
from station.results.parameters_by_name import Parameter, ParameterShift, largest
from station.results.resolve.comparison import (
    KnownCampaign,
    altered,
    compare,
    compare_diagnoses,
    diagnosis_remarks,
    is_otherwise,
    known_of,
)
from station.results.resolve.parallel_map import Engine, Progress, map_restartable
from station.results.resolve.work_item import ItemFault
from station.results.solution_json import software_version
from station.results.verdict import verdict_in_words
from station.text import WIDTH, plural


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
    """Hash a campaign's files; raise `DataRefused` if there is no such folder here.

    ``inputs`` are the names of what a solve reads, ``found`` is name to SHA-256 of every file that is there,
    ``sums`` the same as ``SHA256SUMS`` has it, None where there is none, and ``fault`` why that cannot be read.
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

    Raise `DataRefused` if it breaks a rule of `campaign/1`, or has other bytes than whoever asks saw;
    `NotObservable` if neither triad can be solved.
    """
    loaded = read_for_solve([Path(task.folder)])[0]
    for name, sha256 in loaded.files.items():
        if (expected := task.files.get(name)) != sha256:
            raise DataRefused(Path(task.folder) / name, None, f"sha256 {sha256} on {socket.gethostname()}",
                              f"{expected} as a moment ago", "let nobody write there, then repeat")  # fmt: skip
    from procedures.calibration.joint_calibration import solve
    from station.results.diagnosis.model_refinement import added_effects, refine_model
    from station.results.result_formats import document_of
    from station.results.solution_json import solution_document

    closed = refine_model([loaded])
    is_with_effects = bool(loaded.effects or added_effects(loaded.folder))
    solution = closed.solution if is_with_effects else solve([loaded.campaign])
    diagnosis = {name: part for name, part in closed.document.items() if name != "solution"}
    found = solution_document(solution, [loaded], closed.effects if is_with_effects else ())
    return {"solution": document_of(found), "diagnosis": diagnosis}


def _inputs(folder: Path) -> list[str]:
    try:
        tables = read_campaign_toml(folder)[0]
        return [CAMPAIGN_TOML, *(step.file for step in tables.steps()), *tables.effect_files()]
    except DataRefused:  # the solve will say it again, and whether the file was altered shows in its hash
        return [CAMPAIGN_TOML]


def _sha256(folder: Path, name: str) -> str | None:
    try:
        return sha256_inside(folder, name, folder, None)
    except (DataRefused, OSError):
        return None


FORMAT = "resolve/1"
FileCheck = Mapping[str, Any]


@dataclass(slots=True)
class _Campaign:
    """What is gathered of a campaign: what was known, what its files are, its documents, or why there is none."""

    known: KnownCampaign
    seen: FileCheck | None = None
    documents: Mapping[str, Any] | None = None
    fault: ItemFault | None = None
    was_kept: bool = False


def resolve_fleet(
    folders: Sequence[str], database: Database, engine: Engine, keep: Path, stream: TextIO
) -> dict[str, Any]:
    """Solve campaigns again and compare each with what was known of it; progress goes to ``stream``.

    ``folders`` are resolved paths, the same on this machine and on every worker. Solutions are put into ``keep``
    as they arrive; what is there for the same files, the same code and the same path is not computed again.
    """
    with database.read() as session:
        campaigns = [_Campaign(known_of(session, folder)) for folder in folders]
    _look(campaigns, engine, stream)
    _solve([one for one in campaigns if one.seen is not None], engine, keep, stream)
    with database.read() as session:
        models = {one.documents["solution"]["provenance"]["model"] for one in campaigns if one.documents}
        limits = {model: limits_of(session, model) for model in models}
    return {
        "format": FORMAT,
        "software": software_version(),
        "created_utc": datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z"),
        "campaigns": [_entry(one, limits) for one in campaigns],
    }


def _look(campaigns: Sequence[_Campaign], engine: Engine, stream: TextIO) -> None:
    progress = Progress(stream, "files checked", len(campaigns))
    items = [CheckTask(one.known.folder, tuple(one.known.steps)) for one in campaigns]
    for i, answer in engine.run(check_files, items):
        campaigns[i].seen, campaigns[i].fault = answer.result, answer.fault
        progress.advance(is_fault=answer.fault is not None)
    progress.end()


def _solve(campaigns: Sequence[_Campaign], engine: Engine, keep: Path, stream: TextIO) -> None:
    progress = Progress(stream, "solved", len(campaigns))
    tasks = [_task(one) for one in campaigns]
    for done in map_restartable(resolve_one, tasks, asdict, keep, engine):
        one = campaigns[done.index]
        one.documents, one.fault, one.was_kept = done.answer.result, done.answer.fault, done.was_kept
        progress.advance(was_kept=done.was_kept, is_fault=one.fault is not None)
    progress.end()


def _task(campaign: _Campaign) -> SolveTask:
    seen = campaign.seen or {}
    found = seen["found"]
    return SolveTask(campaign.known.folder, {name: found[name] for name in seen["inputs"] if name in found})


def _entry(campaign: _Campaign, limits: Mapping[str, Sequence[Limit]]) -> dict[str, Any]:
    known, before = campaign.known, campaign.known.before
    entry: dict[str, Any] = {"folder": known.folder, "outcome": _outcome(campaign)}
    if before is not None:
        origin = before.document.get("provenance", before.document)
        entry["before"] = {"kind": before.kind, "name": before.name, "software": origin.get("software", "")}
        entry["model"], entry["serial"] = origin["model"], origin["serial"]
    if campaign.seen is not None:
        entry["altered"] = altered(known, campaign.seen)
    if campaign.fault is not None:
        fault = campaign.fault
        return entry | {"reason": fault.text, "exit_code": fault.code, "host": fault.host}
    assert campaign.documents is not None
    solution = campaign.documents["solution"]
    origin = solution["provenance"]
    entry |= {"model": origin["model"], "serial": origin["serial"], "was_kept": campaign.was_kept}
    entry |= compare(solution, before, limits[origin["model"]])
    known_diagnosis = None if before is None else before.diagnosis
    return entry | {"diagnosis": compare_diagnoses(campaign.documents["diagnosis"], known_diagnosis)}


def _outcome(campaign: _Campaign) -> str:
    if campaign.documents is not None:
        return "solved"
    is_missing = campaign.seen is None and not Path(campaign.known.folder).is_dir()
    return "missing" if is_missing else "refused"


MIN_SHIFT_SIGMAS = 1.0  # sigma: a shift below is what better arithmetic does, and is only counted
Entry = Mapping[str, Any]


def turned_fail(entry: Entry) -> bool:
    """Say whether a verdict was not FAIL before and is now."""
    verdict = entry.get("verdict", {})
    return bool(verdict.get("now") == "FAIL" != verdict.get("before", "FAIL"))


def exit_code(document: Mapping[str, Any]) -> int:
    """Return what the command ends with.

    1 where a verdict turned FAIL or a recording was altered; the first refusal's code where nothing was solved.
    """
    entries = document["campaigns"]
    if any(turned_fail(one) or one.get("altered") for one in entries):
        return 1
    is_solved = any(one["outcome"] == "solved" for one in entries)
    return 0 if is_solved else next((int(one["exit_code"]) for one in entries if one.get("exit_code")), 0)


def resolve_text(document: Mapping[str, Any]) -> str:
    """Return the summary; a path longer than a line is not broken."""
    entries = document["campaigns"]
    lines = _fold(f"{plural(len(entries), 'campaign')}, {document['software']}: {_counted(entries)}", "")
    lines += _shift_lines(entries)
    for entry in entries:
        if wording := list(_remarks(entry)):
            unit = f"  {entry['model']} {entry['serial']}" if "model" in entry else ""
            lines += ["", f"{entry['folder']}{unit}", *(line for text in wording for line in _fold(text, "  "))]
    return "\n".join(lines)


def shift_of(entry: Entry) -> ParameterShift | None:
    """Return a campaign's largest shift, in sigmas of what was known before."""
    moved = {
        name: ParameterShift(
            Parameter(name, row["now"], row["std_before"], row["unit"]),
            row["now"] - row["before"],
            row["shift_sigma"],
        )
        for name, row in entry.get("shifts", {}).items()
    }
    return largest(moved)


def _counted(entries: Sequence[Entry]) -> str:
    kinds: tuple[tuple[str, Callable[[Entry], Any]], ...] = (
        ("solved", lambda one: one["outcome"] == "solved"),
        ("of them kept from an earlier run", lambda one: one.get("was_kept")),
        ("refused", lambda one: one["outcome"] == "refused"),
        ("with no folder", lambda one: one["outcome"] == "missing"),
        ("altered", lambda one: one.get("altered")),
        ("turned FAIL", turned_fail),
        ("with another verdict", _is_changed),
        ("with another diagnosis", is_otherwise),
        ("with new warnings", lambda one: one.get("new_warnings")),
        ("with nothing to compare with", lambda one: one["outcome"] == "solved" and "before" not in one),
    )
    counts = ((sum(bool(holds(one)) for one in entries), name) for name, holds in kinds)
    return ", ".join(f"{count} {name}" for count, name in counts if count)


def _shift_lines(entries: Sequence[Entry]) -> list[str]:
    found = [(shift, one) for one in entries if (shift := shift_of(one)) is not None]
    if not found:
        return []
    sizes = [abs(shift.sigmas) for shift, _ in found]
    most, entry = found[sizes.index(max(sizes))]
    text = (
        f"largest change of a campaign, in units of its earlier uncertainty u: median {median(sizes):.2g}, at "
        f"most {max(sizes):.2g}, {most.parameter.title} of {entry['model']} {entry['serial']}"
    )
    return _fold(text, "")


def _is_changed(entry: Entry) -> bool:
    verdict = entry.get("verdict", {})
    return "before" in verdict and verdict["before"] != verdict["now"]


def _remarks(entry: Entry) -> Iterator[str]:
    for row in entry.get("altered", []):
        yield f"ALTERED {row['file']}: found {row['found']}, expected {row['expected']} ({row['record']})"
    if entry["outcome"] == "missing":
        yield "no such folder: find it, or restore it from a copy"
    elif entry["outcome"] == "refused":
        again = "solved before, refused now" if "before" in entry else "refused"
        yield f"{again}: {entry['reason']}"
    if _is_changed(entry):
        verdict = entry["verdict"]
        was, now = (
            verdict_in_words(verdict[when], has_limits=verdict["limits"] > 0) for when in ("before", "now")
        )
        yield f"{was} before, {now} now: {verdict['reason']}"
    if (shift := shift_of(entry)) is not None and abs(shift.sigmas) >= MIN_SHIFT_SIGMAS:
        yield f"moved: {shift.parameter.title} {shift}"
    yield from diagnosis_remarks(entry)
    for name in entry.get("lost", []):
        yield f"no more estimated: {name}"
    for text in entry.get("new_warnings", []):
        yield f"new warning: {text}"


def _fold(text: str, indent: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "  ",
                break_long_words=False, break_on_hyphens=False)  # fmt: skip

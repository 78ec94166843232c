"""Many campaigns, each solved again by whoever has time, to one `resolve/1`. The database is only read."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from fixtures_db.database import Database
from fixtures_db.model_limits import Limit, limits_of
from station.results.cluster.engine import Engine
from station.results.cluster.progress import Progress
from station.results.cluster.restartable_map import map_restartable
from station.results.cluster.work_item import ItemFault
from station.results.resolve.campaign_task import CheckTask, SolveTask, check_files, resolve_one
from station.results.resolve.diagnosis_comparison import compare_diagnoses
from station.results.resolve.previous_solution import KnownCampaign, known_of
from station.results.resolve.solution_comparison import altered, compare
from station.results.solution_json import software_version

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
    """Solve campaigns again and compare each with what was known of it.

    Parameters
    ----------
    folders
        Resolved paths, the same on this machine and on every worker.
    keep
        The folder where solutions are kept as they arrive; what is there for the same files, the same code and
        the same path is not computed again.
    stream
        Where progress is said.
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
